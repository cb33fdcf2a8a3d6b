"""The pages build without a warning, every link leads somewhere, and what is generated is up to date."""

import re
import subprocess
import sys

import pytest

from reference.pages import RESULTS, write_pages
from reference.pages_gallery import read_workflow, write_gallery
from tests.docs.pages import DOCS, LINK, ROOT, anchors, pages, prose

CONFIGURATION = DOCS / "mkdocs" / "mkdocs.yml"


def test_mkdocs_builds_strictly(tmp_path):
    command = [
        sys.executable,
        "-m",
        "mkdocs",
        "build",
        "--strict",
        "-f",
        CONFIGURATION,
        "-d",
        tmp_path / "site",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    built = {path.relative_to(tmp_path / "site") for path in (tmp_path / "site").rglob("*.html")}
    assert {page.relative_to(DOCS).with_suffix(".html") for page in DOCS.rglob("*.md")} <= built
    loaded = re.findall(
        r'<(?:script|link|img)[^>]+(?:src|href)="(https?:[^"]+)"', (tmp_path / "site/index.html").read_text()
    )
    assert loaded == [], "a page must not need the network"


def test_every_page_is_in_the_menu():
    menu = CONFIGURATION.read_text()
    for page in DOCS.rglob("*.md"):
        assert f": {page.relative_to(DOCS)}\n" in menu, page


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    for target in LINK.findall(prose(page.read_text(encoding="utf-8"))):
        if target.startswith(("http://", "https://")):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), f"{page}: {target}"
        if anchor:
            assert anchor in anchors(path), f"{page}: {target}"


def test_generated_pages_are_those_of_the_stored_results(tmp_path):
    write_pages(RESULTS, tmp_path)
    for name in ("verification.md", "performance.md", "gallery.md"):
        assert (DOCS / name).read_text() == (tmp_path / name).read_text(), "run: python -m reference pages"


def test_the_gallery_shows_every_workflow(tmp_path):
    page = (DOCS / "gallery.md").read_text()
    write_gallery(tmp_path)
    folders = {case.parent for case in (ROOT / "workflows").glob("*/case.toml")}
    for folder in folders:
        kept = DOCS / "pictures" / "gallery" / f"{folder.name}.png"
        assert kept.is_file(), "run: python -m reference pages"
        assert kept.read_bytes() == (tmp_path / "pictures" / "gallery" / kept.name).read_bytes(), kept
        assert f"`workflows/{folder.name}`" in page
        assert f"geodem run workflows/{folder.name}" in page or f"workflows/{folder.name} " in page
    assert len(list((DOCS / "pictures" / "gallery").iterdir())) == len(folders)


@pytest.mark.parametrize("lacking", ["picture", "command", "title", "paragraph", "README"])
def test_a_workflow_without_a_picture_is_refused(tmp_path, lacking):
    folder = tmp_path / "new_one"
    folder.mkdir()
    (folder / "case.toml").write_text('workflow = "ground"\n[source]\nimage = "section.png"\n')
    for name in ("section.png", "result.png"):
        (folder / name).write_bytes(b"")
    parts = {
        "title": "# A question", "paragraph": "What is\n[it](../x/README.md)?", "input": "![Drawing](section.png)",
        "command": "    geodem run workflows/new_one   # a minute", "picture": "![Answer](result.png)",
    }  # fmt: skip
    (folder / "README.md").write_text("\n\n".join(parts.values()))
    found = read_workflow(folder)
    assert (found.title, found.paragraph, found.caption) == ("A question", "What is it?", "Answer")
    assert found.commands == ("geodem run workflows/new_one   # a minute",)
    assert found.picture == folder / "result.png"
    (folder / "README.md").write_text("\n\n".join(text for name, text in parts.items() if name != lacking))
    if lacking == "README":
        (folder / "README.md").unlink()
    with pytest.raises(ValueError, match="lacks .*" + ("a picture" if lacking == "README" else lacking)):
        read_workflow(folder)


def test_every_workflow_has_a_test_that_runs_it():
    tests = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "tests" / "workflows").glob("test_*.py")
    )
    names = [case.parent.name for case in (ROOT / "workflows").glob("*/case.toml")]
    assert len(names) > 15
    assert [name for name in names if f'"{name}"' not in tests] == []


def test_pictures_are_light():
    pictures = list((DOCS / "pictures").rglob("*.png"))
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < 300_000, picture
