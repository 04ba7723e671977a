"""Sources of the site from the repository's documents, and a check of its links.

    site.py gather FOLDER   the documents as Sphinx reads them, with a configuration and a table of contents
    site.py headers FOLDER  FOLDER/Doxyfile names the headers that are installed
    site.py check FOLDER    every link and every anchor between the site's own pages leads somewhere
"""

import html.parser
import pathlib
import re
import shutil
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]

CONTENTS = {
    "Begin": ["tutorial", "install"],
    "Guides": ["methods", "advect", "render", "film", "view", "import", "export", "blender", "python", "distributed"],
    "Reference": ["formats", "measure", "evidence", "algorithm", "architecture"],
    "Project": ["changelog", "CONTRIBUTING"],
}

CONFIGURATION = """
project = "VDBLIC"
release = version = "{version}"
copyright = "2026, the VDBLIC authors"
extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "VDBLIC " + version
html_show_sphinx = False
html_copy_source = False
html_extra_path = ["pages"]
suppress_warnings = ["myst.header"]
"""


# What the site opens with, of pages that site.sh makes.
FLOWS = """<iframe src="flows/wake.html" title="The wake of a prism on a wall" style="width:100%;height:480px;border:0">
</iframe>

*The wake of a prism on a wall; turn it. More: <a href="flows/tornado.html">a tornado</a> and
<a href="flows/rossby.html">a wave on the Earth</a>.*
"""


def sites_name(document):
    """Where a document of the repository is in the site's sources."""
    if document.suffix == ".md" and document.parent != ROOT / "docs" and ROOT / "docs" not in document.parents:
        names = {ROOT / "README.md": "index.md", ROOT / "CHANGELOG.md": "changelog.md"}
        return pathlib.Path(names.get(document, f"{document.parent.name}.md"))
    if ROOT / "docs" in document.parents:
        return document.relative_to(ROOT / "docs")
    return document.relative_to(ROOT)


def moved(text, document, folder):
    """A document's text with links as they are in the site; files that are no documents are copied into it."""
    def link(found):
        target, _, anchor = found[1].partition("#")
        if not target or ":" in target:
            return found[0]
        there = (document.parent / target).resolve()
        name = sites_name(there)
        if there.is_dir() or not there.exists():
            raise SystemExit(f"{document}: {target} is no file")
        if there.suffix != ".md" and name == there.relative_to(ROOT):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(there, folder / name)
        depth = len(sites_name(document).parts) - 1
        return f"]({'../' * depth}{name}{'#' if anchor else ''}{anchor})"
    return re.sub(r"\]\(([^)\s]+)\)", link, text)


def gather(folder):
    documents = [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "samples/wake/README.md", *(ROOT / "docs").rglob("*.md")]
    for document in documents:
        path = folder / sites_name(document)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(moved(document.read_text(encoding="utf-8"), document, folder), encoding="utf-8")
    shutil.copytree(ROOT / "docs/images", folder / "images")
    lists = []
    for title, pages in CONTENTS.items():
        lines = "\n".join([*pages, *(["wake"] if title == "Begin" else [])])
        lists.append(f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n{lines}\n```\n")
    index = folder / "index.md"
    reference = '\n<a href="api/index.html">The library\'s headers</a> have a reference of their own.\n'
    title, text = index.read_text(encoding="utf-8").split("\n", 1)
    index.write_text("\n".join([title, "", FLOWS, text, reference, *lists]), encoding="utf-8")
    version = re.search(r"project\(vdblic VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    (folder / "conf.py").write_text(CONFIGURATION.format(version=version), encoding="utf-8")


def headers(folder):
    lists = (ROOT / "lib/CMakeLists.txt").read_text(encoding="utf-8")
    folders = re.findall(r"^ *vdblic_folder\((\w+)\n[^)]*HEADERS ([^)]*)\)", lists, re.MULTILINE)
    names = [f"lib/vdblic/{name}/{header}" for name, files in folders for header in files.split()]
    first = folder / "headers.md"
    first.write_text('# The library\'s headers {#headers}\n\n<a href="../architecture.html#the-library-in-your-program">The guide</a> tells which to begin with. '
                     f"This reference has the {len(names)} that are installed.\n", encoding="utf-8")
    (folder / "Doxyfile").write_text(f"INPUT = {first} {' '.join(names)}\nUSE_MDFILE_AS_MAINPAGE = {first}\n", encoding="utf-8")


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], {"", "top"}
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        self.links += [attributes[name] for name in ("href", "src") if attributes.get(name)]


def check(folder):
    pages = {path: Page(path) for path in folder.rglob("*.html")}
    links, broken = 0, []
    for path, page in pages.items():
        for link in page.links:
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc or link.startswith("javascript:"):
                continue
            links += 1
            there = (path.parent / urllib.parse.unquote(address.path)).resolve() if address.path else path
            there = there / "index.html" if there.is_dir() else there
            anchor = urllib.parse.unquote(address.fragment)
            missing = there in pages and anchor not in pages[there].anchors and "api" not in path.parts  # Doxygen's own
            if not there.is_file() or missing:
                broken.append(f"{path.relative_to(folder)}: {link}")
    print(*broken, sep="\n", end="\n" if broken else "")
    print(f"{len(pages)} pages, {links} links, {len(broken)} broken")
    return 1 if broken else 0


if __name__ == "__main__":
    action, target = sys.argv[1:]
    sys.exit({"gather": gather, "headers": headers, "check": check}[action](pathlib.Path(target).resolve()))
