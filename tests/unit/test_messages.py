"""What the core says is for every interface: none of its messages names an option of the command line."""

import ast
import re
from pathlib import Path

import pytest

from tools.environment import ROOT

OPTION = re.compile(r"--[a-z]")


def options_in_messages(source: str) -> list[tuple[int, str]]:
    """Return line and text of the string literals that name an option, but for options by themselves."""
    texts = [
        (node.lineno, node.value)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    return [(line, text) for line, text in texts if OPTION.search(text) and not re.fullmatch(r"--[a-z0-9-]+", text)]


@pytest.mark.parametrize("path", sorted((ROOT / "core").rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_message_of_the_core_names_an_option_of_the_command_line(path: Path) -> None:
    assert options_in_messages(path.read_text()) == []


def test_an_option_in_a_message_is_found() -> None:
    source = 'x = 1\nraise ValueError(f"{x}: choose it with --depth-column.")\ncommand.add_argument("--json")\n'
    assert options_in_messages(source) == [(2, ": choose it with --depth-column.")]
