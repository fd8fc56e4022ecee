"""What the documentation points at is there: files, pictures, headings, commands."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import dev
from studies.commands import COMMANDS
from tools.environment import ROOT

PAGES = [path for folder in ("", "docs", "studies", "tests/bench") for path in sorted((ROOT / folder).glob("*.md"))]
LONGEST = {"README.md": 130, "CHANGELOG.md": 50, "CONTRIBUTING.md": 90}  # [lines]
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
PATH = re.compile(r"`((?:addon|blend_samples|core|docs|operators|studies|tests|tools)/[\w./-]*)`")
COMMAND = re.compile(r"dev\.py (?!-)([a-z]+)(?: ([a-z]+))?")

everywhere = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())


def anchors(page: Path) -> set[str]:
    """Return what a link may name behind #: headings, as GitHub writes them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}


def missing_links(page: Path) -> Iterator[str]:
    for link in LINK.findall(page.read_text()):
        name, _, anchor = link.partition("#")
        target = page.parent / name if name else page
        if not link.startswith("http") and not (target.exists() and (not anchor or anchor in anchors(target))):
            yield link


@everywhere
def test_links_and_pictures_resolve(page: Path) -> None:
    assert list(missing_links(page)) == []


@everywhere
def test_paths_in_the_text_exist(page: Path) -> None:
    assert [path for path in PATH.findall(page.read_text()) if not (ROOT / path).exists()] == []


@everywhere
def test_commands_in_the_text_exist(page: Path) -> None:
    names = {action.__name__ for action in dev.COMMANDS}
    found = COMMAND.findall(page.read_text())
    assert [name for name, _ in found if name not in names] == []
    assert [study for name, study in found if name == "core" and study and study not in COMMANDS] == []


@pytest.mark.parametrize("name", LONGEST)
def test_a_page_is_no_longer_than_a_page(name: str) -> None:
    assert len((ROOT / name).read_text().splitlines()) <= LONGEST[name]


def test_the_readme_shows_before_it_explains() -> None:
    """The looping press comes first, then the tool in the viewport; every page of docs/ is linked."""
    text = (ROOT / "README.md").read_text()
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)
    assert pictures == ["blend_samples/press.webp", "blend_samples/two_materials.webp"]
    assert text.splitlines()[2].startswith("![")
    assert {path.name for path in (ROOT / "docs").glob("*.md")} == set(re.findall(r"docs/(\w+\.md)[)#]", text))
