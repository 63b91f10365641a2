"""The front page is short, says what it must, and its table of others links to their own words."""

import re

import pages
from helpers import ROOT

README = (ROOT / "README.md").read_text()
MOST_WORDS = 600


def prose(text):
    """The words of a page outside of its code, its outputs, its tables and its pictures; a link is its words."""
    text = pages.FENCE.sub("", text)
    lines = [line for line in text.splitlines() if not line.startswith(("|", "!["))]
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", "\n".join(lines))
    return re.findall(r"\w[\w'./=-]*", text)


def test_words_are_counted_outside_of_code_and_tables():
    text = "# A title\n\n```sh\nnot one word\n```\n\n| no | no |\n\n![none](x.png)\n\n[two words](y.md), and r_r = 3.\n"
    assert prose(text) == ["A", "title", "two", "words", "and", "r_r", "3."]


def test_the_front_page_is_short():
    assert 300 < len(prose(README)) <= MOST_WORDS, len(prose(README))


def test_it_begins_with_its_picture_and_the_purpose():
    head = README.split("\n## ")[0]
    assert "odometry" in head
    assert re.search(r"^!\[.+\]\(.+\)$", head, re.MULTILINE)


def test_it_has_four_recipes_each_with_its_page():
    recipes = README.split("## Four recipes\n")[1].split("\n## ")[0]
    assert len(re.findall(r"^\*\*", recipes, re.MULTILINE)) == 4
    assert len(re.findall(r"\(\[how\]\(docs/howto/[\w-]+\.md\)\)", recipes)) == 4


def test_others_are_compared_by_their_own_pages():
    rows = re.findall(
        r"^\| (?:\*\*)?\[?(\w+)(.*)$", README.split("## How it compares")[1].split("\n## ")[0], re.MULTILINE
    )
    assert [name for name, _ in rows] == ["diffdrive_mj", "ros2_controllers", "WPILib", "evo", "OptiOdom", "Gazebo"]
    for name, row in rows[1:]:
        assert "](https://" in row, name
