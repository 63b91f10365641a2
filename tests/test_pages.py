"""The pages do what they say: their commands and their Python run and print it, and their links lead somewhere."""

import contextlib
import re
import tomllib

import pages
import pytest
from helpers import ROOT

import diffdrive_mj as dd
from diffdrive_mj import cli
from diffdrive_mj.judging.standards import STANDARD_MANEUVERS, residual
from diffdrive_mj.robot import presets

PAGES = pages.every_page()
README = ROOT / "README.md"
# Commands that cannot run here, by their page, and why.
NOT_RUN = {
    "README.md": {"pip install": "an installation takes a network; tests/test_wheel.py installs the package"},
    "docs/tutorial.md": {"pip install": "the same"},
    "docs/howto/read-a-bag.md": {"pip install": "the same"},
    "docs/play.md": {
        "diffdrive play": "it serves a page until Ctrl-C; tests/play asks it for that page",
        "npm install": "an installation takes a network; `.ci/run` has `npm ci`",
    },
    "docs/howto/run-on-a-cluster.md": {"#SBATCH": "it takes a hundred machines; the block before it takes this one"},
    "models/README.md": {"mujoco.viewer": "it opens a window"},
}

by_page = pytest.mark.parametrize("page", PAGES, ids=pages.name)


@by_page
def test_a_page_followed_word_by_word_prints_what_it_says(page, tmp_path, request):
    if re.search(r"^diffdrive film |dd\.film\(", page.read_text(), re.MULTILINE):
        request.getfixturevalue("opengl")
    missing = pages.follow(page.read_text(), tmp_path)
    if missing:
        pytest.skip(f"all but the blocks that need {', '.join(missing)} ran")


COMMAND = r"^ *(?:\$ )?(?:diffdrive|python3?|pip|pytest|make|npm|node|cc|\./\w+|cd|cp|import|from) .*"


@by_page
def test_no_command_is_there_only_to_look_at(page):
    looked_at = [block.text for block in pages.blocks(page.read_text()) if block.kind in ("text", "yaml", "c")]
    assert re.findall(COMMAND, "".join(looked_at), re.MULTILINE) == []


@by_page
def test_what_may_fail_unnoticed_is_compared(page):
    """Only the last command of a pipe, and none before "||", ends a block."""
    unseen = [block for block in pages.blocks(page.read_text()) if block.kind == "sh" and block.output is None]
    assert [block.text for block in unseen if "|" in block.text] == []


@by_page
def test_commands_in_a_sentence_have_their_options(page, capsys):
    text = page.read_text()
    spans = re.findall(r"`(diffdrive [^`]+)`", pages.FENCE.sub("", text))
    not_run = [block.text for block in pages.blocks(text) if block.kind == "sh not-run"]
    for line in [*spans, *re.findall(r"^diffdrive .*", "".join(not_run), re.MULTILINE)]:
        command, *words = line.split(" -- ")[0].split()[1:]
        if command == "COMMAND" or command.startswith("-"):
            continue
        verbs = [word for word in words[:1] if command in ("robots", "experiment") and word.islower()]
        with contextlib.suppress(SystemExit):  # what is no command leaves nothing on stdout
            cli.main([command, *verbs, "--help"])
        said = capsys.readouterr().out
        assert said.startswith("usage: "), line
        options = [word.split("=")[0] for word in words if word.startswith("--")]
        assert [option for option in options if not re.search(rf"{option}(?![\w-])", said)] == [], line


@by_page
def test_what_is_not_run_has_a_reason(page):
    blocks = [block.text for block in pages.blocks(page.read_text()) if block.kind == "sh not-run"]
    reasons = NOT_RUN.get(pages.name(page), {})
    assert [text for text in blocks if not any(part in text for part in reasons)] == []
    assert [part for part in reasons if not any(part in text for text in blocks)] == []


@by_page
def test_robots_in_pages_are_robots(page, tmp_path):
    for block in pages.blocks(page.read_text()):
        if block.kind == "toml":
            assert dd.Robot(**tomllib.loads(block.text)).mass > 0


@pytest.mark.parametrize(
    "hidden",
    [
        "- a list\n\n  ```sh\n  false\n  ```\n",  # indented
        "~~~sh\nfalse\n~~~\n",
        "```sh\nfalse\n",  # never closed
        "```text\nwords\n``` \n\n```sh\nfalse\n```\n",  # closed with a blank behind, so that it goes on
        "words\n\n    diffdrive nonsense\n",
        "<pre>diffdrive nonsense</pre>\n",
    ],
)
def test_code_that_would_be_passed_over_is_refused(hidden):
    with pytest.raises(ValueError, match=r"line \d: (code that is no block|a block with a fence inside)"):
        pages.blocks(f"before\n\n```sh\ntrue\n```\n\n{hidden}")


def test_a_block_of_no_known_kind_is_refused():
    with pytest.raises(ValueError, match="line 3: a block of the kind 'ruby'"):
        pages.blocks("a\n\n```ruby\nputs 1\n```\n")
    with pytest.raises(ValueError, match="line 1: a block of the kind ''"):
        pages.blocks("```\nsomething\n```\n")
    with pytest.raises(ValueError, match="line 7"):  # an output is right after its commands
        pages.blocks("```sh\ntrue\n```\n\nwords\n\n```\n1\n```\n")
    (block,) = pages.blocks("```sh\necho 1\n```\n\n```\n1\n```\n")
    assert (block.kind, block.output) == ("sh", "1\n")


@pytest.mark.parametrize(
    ("printed", "said", "same"),
    [
        ("1.000001 m", "1 m", True),  # within 1e-5
        ("1.0001 m", "1.0002 m", False),
        ("1 m", "1 mm", False),
        ("1 m", "1 m\n", False),
        ("-1", "1", False),
    ],
)
def test_outputs_are_compared(printed, said, same):
    with contextlib.nullcontext() if same else pytest.raises(AssertionError):
        pages.compare(printed, said)


def test_commands_that_fail_or_warn_are_noticed(tmp_path):
    reader = pages.Reader(tmp_path)
    for text in ("false\n", "echo oh >&2\n", "diffdrive robots show nobody\n"):
        with pytest.raises(AssertionError):
            reader.follow(pages.Block("sh", text, 1))
    with pytest.raises(ZeroDivisionError):
        reader.follow(pages.Block("python", "1 / 0\n", 1))


@pytest.mark.parametrize(
    "lie",
    [
        "```sh\necho 1\n```\n\n```\n2\n```\n",
        "```python\nprint(1)\n```\n\n```\n2\n```\n",
        "```sh\nfalse\n```\n",
        '```python\ndef f():\n    """\n    >>> 1\n    2\n    """\n```\n',
    ],
)
def test_a_page_that_lies_is_noticed(lie, tmp_path):
    true = "```python\nx = 1\n```\n\n```python\nprint(x)\n```\n\n```\n1\n```\n\n```sh\nls | wc -l\n```\n\n```\n1\n```\n"
    for page in (lie, f"{true}\n{lie}"):
        with pytest.raises(AssertionError):
            pages.follow(page, tmp_path)
        (tmp_path / "examples").unlink()
    assert pages.follow(true, tmp_path) == set()


def linked(page):
    """The files and headings that a page links to; a heading is none where the whole file is meant."""
    text = pages.FENCE.sub("", page.read_text())
    inline, defined = r"\]\((?!http|data:)([^)#]*)(#([^)]+))?\)", r"^\[[^\]]+\]: (?!http)([^\s#]*)(#(\S+))?$"
    for file, _, heading in re.findall(inline, text) + re.findall(defined, text, re.MULTILINE):
        yield page.parent / file if file else page, heading


def anchors(page):
    """The headings of a page, as links name them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@by_page
def test_links_and_pictures_lead_to_files_and_headings(page):
    for file, heading in linked(page):
        assert file.is_file(), file  # a folder is no page
        assert not heading or heading in anchors(file), heading


def test_the_front_page_leads_to_every_page():
    found, waiting = set(), [README]
    while waiting:
        page = waiting.pop()
        found.add(page.resolve())
        waiting += [file for file, _ in linked(page) if file.suffix == ".md" and file.resolve() not in found]
    assert {page.resolve() for page in PAGES} == found


def test_the_targets_of_make_exist():
    makefile = (ROOT / "Makefile").read_text()
    for command in re.findall(r"(?:^|`)make ([a-z]+)", "".join(page.read_text() for page in PAGES), re.MULTILINE):
        assert re.search(rf"^{command}:", makefile, re.MULTILINE), command


def table(page, heading):
    """The rows of the first table below a heading of a page."""
    section = page.read_text().split(f"{heading}\n", 1)[1]
    rows = re.search(r"^\|.*\n\|[ -|]+\n((?:\|.*\n)+)", section, re.MULTILINE)[1].splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in rows]


def test_every_experiment_has_its_row_section_and_picture():
    page = ROOT / "experiments" / "README.md"
    scripts = {script.stem for script in (ROOT / "experiments").glob("*.py")}
    assert {name.strip("`") for name, _ in table(page, "# Experiments")} == scripts
    for name in scripts:
        assert f"## {name}" in page.read_text()
        assert (ROOT / "experiments" / "pictures" / f"{name}.png").is_file()


def test_the_presets_are_those_that_there_are():
    rows = table(ROOT / "models" / "README.md", "## Presets")
    assert sorted(row[0].strip("`") for row in rows) == list(presets())
    for name, radii, track, _ in rows:
        robot = dd.Robot.load(name.strip("`"))
        left, right = (float(radius) for radius in (radii.split(", ") * 2)[:2])
        assert (left, right, float(track)) == (robot.left_radius, robot.right_radius, robot.track_width)


def test_the_floor_is_what_the_physics_leaves():
    rows = table(ROOT / "experiments" / "README.md", "## physics_floor: how exact is the simulator?")
    said = next(row[1:] for row in rows if row[0] == "as delivered")
    robot = dd.Robot.load("mismatched")
    for figure, commands_for in zip(said, STANDARD_MANEUVERS.values(), strict=True):
        measured = residual(dd.simulate(robot, commands_for(robot)), robot)
        assert float(figure) == pytest.approx(measured.position, rel=0.1)


def test_the_program_in_c_is_the_example():
    page = (ROOT / "docs" / "howto" / "judge-my-code.md").read_text()
    program = page.split("cat > odometry.c << 'END'\n")[1].split("END\n")[0]
    assert program == (ROOT / "examples" / "odometry.c").read_text()
