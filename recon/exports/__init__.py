"""Maps and clouds as files of other programs, and back."""
