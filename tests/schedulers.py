"""A scheduler that tests of several rooms share."""

import pickle


class Sent:
    """A scheduler that does the calls in this process, as they arrive at a worker."""

    def __init__(self, *_):
        pass

    def outcomes(self, calls):
        yield from (pickle.loads(pickle.dumps(call))() for _, call in calls)
