"""The pages agree with the code."""

import ast
import re
from fnmatch import fnmatchcase
from pathlib import Path

import recon
from recon.settings import Settings, with_preset
from recon.settings.files import to_tree

DOCS = Path(__file__).parents[1] / "docs"


def flat(settings):
    tree = to_tree(settings)
    return {
        f"{stage}.{name}": value for stage, table in tree.items() for name, value in table.items()
    }


def value(text):
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def rows():
    text = (DOCS / "thesis.md").read_text()
    return {
        name: (value(thesis), value(own))
        for name, thesis, own in re.findall(r"^\| `([\w.]+)` \| (.+?) \| (.+?) \|", text, re.M)
    }


def test_table_of_parameters_matches_the_preset():
    own, thesis = flat(Settings()), flat(with_preset(Settings(), "thesis"))
    table = rows()
    assert {name: (thesis[name], own[name]) for name in table} == table


def test_table_covers_every_difference():
    own, thesis = flat(Settings()), flat(with_preset(Settings(), "thesis"))
    assert {name for name in own if own[name] != thesis[name]} <= set(rows())


def test_messages_on_the_troubleshooting_page_occur_in_the_code():
    sources = "".join(path.read_text() for path in (DOCS.parent / "recon").rglob("*.py"))
    # Strings continue on the next line; their placeholders are split off below.
    sources = re.sub(r'"\s*\n\s*f?"', "", sources)
    page = (DOCS / "troubleshooting.md").read_text()
    known = [words for row in re.findall(r"^\| `(.+?)` \|", page, re.M) for words in pieces(row)]
    assert len(known) > 15
    assert [words for words in known if words not in sources] == []


def test_keys_on_the_page_of_files_occur_in_the_code():
    words = set()
    for path in (DOCS.parent / "recon").rglob("*.py"):
        words |= set(re.findall(r"\w+", path.read_text()))
    words |= {word.removesuffix("_rad") + "_deg" for word in words if word.endswith("_rad")}
    page = (DOCS / "reference" / "files.md").read_text()
    keys = set(re.findall(r"`([a-z]+(?:_\w+)+)`", page))
    assert len(keys) > 60
    assert keys - words == set()


def test_reference_of_python_lists_every_public_name():
    page = (DOCS / "reference" / "python.md").read_text()
    listed = re.findall(r"^   (\w+)$", page, re.M)
    assert sorted(listed) == sorted(set(recon.__all__) - {"Image", "__version__"})


def notified(source):
    """The codes of the warnings that a source reports, as texts or constants of its own."""
    nodes = [*ast.walk(ast.parse(source))]
    texts = {
        node.targets[0].id: node.value.value
        for node in nodes
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and isinstance(node.value, ast.Constant)
    }
    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            named = [word.value for word in node.keywords if word.arg == "code"]
            given = {"notify": node.args[:1], "Finding": named}.get(node.func.id, [])
            yield from (code.value for code in given if isinstance(code, ast.Constant))
            codes = [code.id for code in given if isinstance(code, ast.Name)]
            yield from (texts[code] for code in codes if code in texts)


def test_troubleshooting_page_lists_exactly_the_warnings_of_the_code():
    source = "C = 'c-d'\nnotify('a-b', text)\nFinding(code=C, text=text)\nnotify(one.code, text)"
    assert list(notified(source)) == ["a-b", "c-d"]
    sources = (path.read_text() for path in (DOCS.parent / "recon").rglob("*.py"))
    known = {code for source in sources for code in notified(source)}
    page = (DOCS / "troubleshooting.md").read_text()
    assert re.findall(r"^\| `([a-z-]+): \.\.\.` \|", page, re.M) == sorted(known)


def pieces(message):
    """Split a message into its fixed parts."""
    shown = message.replace("different settings", "different ...").replace("las]", "...]")
    return [words for part in shown.split("...") if len(words := part.strip(" :;()'")) > 3]


WRONG = {
    r"\b(an|the|of) own\b": "your own",
    r"\bone's own\b": "your own",
    r"(?<!there )\b(is|are) no [a-z]+\b": "is not a",
    r"\bone an? (pair|row|point|cell)\b": "one per",
    r"\bpictures?\b": "image",
    r"\bcolor\b": "colour, but in code",
    r"^#+ (Whether|Read an)\b": "a noun or a verb",
    r"\b(teh|occured|seperate|recieve|wich|lenght|heigth|calibation|dispari(?!t)\w*)\b": "spelling",
}


def wrong_terms(text):
    prose = re.sub(r"^```.*?^```|`[^`]*`", "", text, flags=re.M | re.S)
    return [found[0] for term in WRONG for found in re.finditer(term, prose, re.M)]


def test_pages_use_standard_terms():
    assert wrong_terms("It is no way to seperate a pair of an own rig.")
    pages = [*DOCS.rglob("*.md"), DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"]
    found = {page.name: wrong for page in pages if (wrong := wrong_terms(page.read_text()))}
    assert found == {}


def pages():
    """Every page of the site."""
    found = [page for page in DOCS.rglob("*.md") if "src" not in page.parts]
    assert len(found) > 30
    return found


def test_every_page_is_in_the_table_of_contents():
    blocks = re.findall(r"```{toctree}\n(.*?)```", (DOCS / "index.md").read_text(), re.S)
    entries = [line for block in blocks for line in block.splitlines() if line[:1] not in ("", ":")]
    names = {page.relative_to(DOCS).with_suffix("").as_posix() for page in pages()} - {"index"}
    listed = {name for name in names for entry in entries if fnmatchcase(name, entry)}
    assert names - listed == set()


def test_links_between_pages_lead_to_files():
    for page in (*pages(), DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"):
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
