"""Pages of results: what is on them, what they make of bad files, how large they get, which files they leave alone."""

import html
import json
import os
import re
from html.parser import HTMLParser

import numpy as np
import page_cases as cases
import pytest
from PIL import Image

from diffdrive_mj import cli, report
from diffdrive_mj.errors import InvalidType, InvalidValue, MissingFile
from diffdrive_mj.report import Bound, Replay, Report
from diffdrive_mj.report._replay_data import in_script
from diffdrive_mj.report._rooms import Room, escaped

VOID = {"meta", "link", "img", "input", "br"}


class Reader(HTMLParser):
    """The elements of a page, with the text of each; elements that do not nest are an error."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.elements, self.open, self.ids = [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes), []))
        self.ids += [value for name, value in attributes if name == "id"]
        if tag not in VOID:
            self.open.append((tag, self.elements[-1][2]))

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        for _, texts in self.open:
            texts.append(data)

    def all(self, tag, **wanted):
        return [
            ("".join(texts), attributes)
            for name, attributes, texts in self.elements
            if name == tag and all(attributes.get(key) == value for key, value in wanted.items())
        ]


def read(folder):
    """The page of a folder."""
    text = report.page(folder).read_text()
    assert len(text.encode()) < 3_000_000
    return Reader(text)


def card(reader, name):
    """The text of a card."""
    ((text, _),) = reader.all("article", id=name)
    return " ".join(text.split())


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return read(cases.good(tmp_path_factory.mktemp("good")))


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    return read(cases.faulty(tmp_path_factory.mktemp("faulty") / "results"))


def test_a_card_says_what_was_asked_and_answered_and_how_to_run_it_again(good):
    text = card(good, "bend")
    for part in (
        "How far off?",
        "Hardly at all.",
        "And more.",
        "a 1",
        "diffdrive experiment bend --seed 3",
        "seed = 3",
    ):
        assert part in text
    for package in ("diffdrive_mj 0.1.0", "mujoco 4", f"numpy {np.__version__}", "python 3."):
        assert package in text
    assert re.search(r"date ?20\d\d-\d\d-\d\d \d\d:\d\d:\d\d UTC", text)


def test_bounds_pass_or_fail_in_words(good):
    rows = [" ".join(text.split()) for text, _ in good.all("tr")]
    assert "error0.2≤ 1 mm✓ holds" in rows
    assert "slip3≤ 1 ppm✗ BROKEN" in rows
    assert "grip2≥ 1 ✓ holds" in rows
    assert "Bounds: 1 of 3 bounds broken" in card(good, "bend")
    assert "Bounds: 1 bound holds" in card(good, "other")


def test_the_overview_counts_bounds_and_names_what_is_broken(good):
    ((summary, _),) = good.all("p", **{"class": "summary"})
    assert summary == "2 questions asked; 3 of 4 bounds hold; 1 broken, in bend."
    lines = [text for text, _ in good.all("li")]
    assert lines == ["How far off?✗ 1 of 3 bounds broken", "And this?✓ 1 bound holds"]
    targets = [attributes["href"][1:] for _, attributes in good.all("a")]
    assert set(targets) <= set(good.ids)
    assert len(good.ids) == len(set(good.ids))


def test_pictures_are_part_of_the_page_and_say_what_they_show(good):
    ((_, image),) = good.all("img")
    assert image["src"].startswith("data:image/webp;base64,")
    assert image["alt"] == "bend: Hardly at all."
    assert (image["width"], image["height"]) == ("504", "330")  # half of what is written at 150 dots an inch


def test_nothing_is_fetched(good):
    for _, attributes, _ in good.elements:
        for name in ("src", "href", "action", "srcset"):
            assert attributes.get(name, "#").startswith(("#", "data:"))
    ((_, policy),) = good.all("meta", **{"http-equiv": "Content-Security-Policy"})
    assert policy["content"].startswith("default-src 'none'; script-src 'sha256-")


def test_a_replay_has_the_errors_that_the_metrics_give(good):
    first, second = [json.loads(text) for text, _ in good.all("script", type="application/json")]
    assert (first["title"], second["title"]) == ("A bend", "The same backwards")
    whole = cases.replay()
    for belief in first["beliefs"]:
        # At the samples that are kept, to the six digits that are written.
        at = np.searchsorted(whole.t, np.array(first["t"]) - 1e-9)
        off = np.hypot(*(whole.beliefs[belief["name"]] - whole.truth)[at, :2].T)
        np.testing.assert_allclose(belief["position_error"], off, rtol=1e-5)
        np.testing.assert_allclose(belief["x"], whole.beliefs[belief["name"]][at, 0], atol=1e-5)
    assert first["robot"]["right_radius"] == 0.091
    assert [belief["robot"]["right_radius"] for belief in first["beliefs"]] == [0.1, 0.091]


FAULTS = {
    "half_written": "metrics.json cannot be read (half written, or no JSON): run the experiment again",
    "no_json": "metrics.json cannot be read (half written, or no JSON)",
    "binary": "metrics.json cannot be read (half written, or no JSON)",
    "deep": "metrics.json cannot be read (half written, or no JSON)",
    "foreign": "metrics.json was not written by an experiment",
    "foreign_list": "metrics.json was not written by an experiment",
    "umbmark": "metrics.json is missing: run the experiment again",
    "old": "written by an older version: the command, the versions and the date are not recorded; run it again",
    "texts": "metrics.json: question is not a text",
    "bounds": "metrics.json: 3 of 4 bounds cannot be read",
    "no_bounds": "metrics.json: bounds is not a list",
    "nothing": "✗ BROKEN",
    "huge_number": "metrics.json: 1 of 1 bounds cannot be read",
    "liar": "✗ BROKEN",
    "no_pictures": "metrics.json: pictures is not a list",
    "missing_picture": "gone.png is missing",
    "outside": "metrics.json: a picture's name cannot be used",
    "long_name": "Is the rest shown? So. xxxxx",
    "no_picture": "text.png cannot be shown (not a picture)",
    "huge_picture": "huge.png cannot be shown (9000 x 9000 pixels)",
    "no_replays": "replays.json is missing",
    "half_replays": "replays.json cannot be read (half written, or no JSON)",
    "bad_replays": "replays.json cannot be read",
    "strange_provenance": "metrics.json: provenance cannot be read",
    "strange_options": "metrics.json: command is not a text",
    "whole": "Is the rest shown? Yes.",
}


@pytest.mark.parametrize(("name", "words"), FAULTS.items(), ids=FAULTS)
def test_what_is_wrong_with_results_stands_on_their_card(faulty, name, words):
    assert words in card(faulty, name)


def test_the_overview_counts_what_cannot_be_read(faulty):
    ((summary, _),) = faulty.all("p", **{"class": "summary"})
    assert summary == "18 questions asked; 2 of 4 bounds hold; 2 broken, in liar, nothing; 8 results cannot be read."


def test_every_fault_has_its_card_and_nothing_else_has_one(faulty):
    assert sorted(attributes["id"] for _, attributes in faulty.all("article")) == sorted(FAULTS)
    assert not any("secret" in str(attributes) for _, attributes, _ in faulty.elements)


def test_text_from_files_stays_text(tmp_path):
    tame, wild = read(cases.good(tmp_path / "good")), read(cases.hostile(tmp_path / "wild"))
    kinds = {tag for tag, _, _ in tame.elements}
    assert {tag for tag, _, _ in wild.elements} <= kinds
    # No attribute, element or script but those of every page.
    for _, attributes, _ in wild.elements:
        assert not any(name.startswith("on") for name in attributes)
    assert len(wild.all("img")) == 1
    assert len(wild.all("script")) == 3
    shown = cases.HOSTILE.replace("\0", r"\x00").replace("\u202e", r"\u202e")
    ((heading, _),) = wild.all("h2", id="result-1-title")
    assert heading == shown
    assert shown in " ".join(text for text, _ in wild.all("pre"))
    assert shown in " ".join(text for text, _ in wild.all("td"))
    ((replay, _),) = wild.all("script", type="application/json")
    assert json.loads(replay)["beliefs"][0]["name"] == cases.HOSTILE[:120]


@pytest.mark.parametrize(
    "name", ["results", "k-by-hand", "player", "Ωmega", "1st", "a b", "result-2", "a-title", "a" * 101]
)
def test_a_folder_of_any_name_has_a_card_of_its_own(tmp_path, name):
    for each in (name, "a", "Ω", "a" * 102):
        Report("Why?", "So.", "", []).write(tmp_path / each)
    (tmp_path / "b").symlink_to("a")
    reader = read(tmp_path)
    assert {"a", "b"} < set(reader.ids)
    assert len(reader.all("article")) == 5
    assert len(reader.ids) == len(set(reader.ids))


def test_an_option_of_nothing_is_said_to_be_none(tmp_path):
    Report("Why?", "So.", "", []).write(tmp_path / "mine", options={"data": "", "seed": 0})
    assert "data = (none), seed = 0" in card(read(tmp_path), "mine")


def test_a_folder_of_one_result_has_a_page_too(tmp_path):
    Report("Why?", "So.", "", []).write(tmp_path / "mine")
    assert "Why?" in card(read(tmp_path / "mine"), "mine")
    # The experiment's own files are still its own.
    Report("Why not?", "So.", "", []).write(tmp_path / "mine")
    assert "Why not?" in card(read(tmp_path / "mine"), "mine")


def noise(size, seed):
    """A picture that no format can make small."""
    return Image.fromarray(np.random.default_rng(seed).integers(0, 256, (*size, 3), dtype=np.uint8))


def test_the_page_stays_small_whatever_there_is_to_show(tmp_path):
    t = np.linspace(0.0, 60.0, 601)
    jitter = np.random.default_rng(0).normal(size=(3, len(t), 3))
    replays = [
        Replay(f"drive {k}", t, jitter[0], {"a": jitter[1], "b" * 5000: jitter[2]}, cases.ROBOT) for k in range(8)
    ]
    names = [f"picture{k}.png" for k in range(4)]
    bounds = [*[Bound("b" * 900, 0.0, 1.0)] * 400, Bound("the last one", 2.0, 1.0)]
    for k in range(2):
        place = tmp_path / f"large{k}"
        Report("Why?" * 50_000, "<&>" * 50_000, "x" * 300_000, bounds, replays=replays).write(place)
        content = json.loads((place / "metrics.json").read_text())
        (place / "metrics.json").write_text(json.dumps(content | {"pictures": names}))
        for name in names:
            noise((600, 1200), k).save(place / name)
    reader = read(tmp_path)
    left_out = sum(card(reader, f"large{k}").count("is left out, or the page would be too large") for k in range(2))
    assert len(reader.all("img")) + len(reader.all("script", type="application/json")) + left_out == 8 + 16
    assert left_out <= 5
    assert "… (cut short)" in card(reader, "large0")
    # Of many bounds the broken ones are shown.
    assert "the last one2≤ 1 ✗ BROKEN" in card(reader, "large1")
    assert "more, in the experiment's metrics.json" in card(reader, "large1")


def test_hundreds_of_results_have_a_page(tmp_path):
    for k in range(600):
        (tmp_path / f"result{k}").mkdir()
        bounds = [{"name": f"bound {i}", "value": float(k == 599), "limit": 0.5} for i in range(20)]
        text = cases.listing(question="<Why?> " * 100, finding="So. " * 300, bounds=bounds, table="x " * 5000)
        (tmp_path / f"result{k}" / "metrics.json").write_text(text)
    reader = read(tmp_path)
    ((summary, _),) = reader.all("p", **{"class": "summary"})
    assert summary.startswith(
        "600 questions asked; 11980 of 12000 bounds hold; 20 broken, in result599; 400 results are "
    )
    # What is broken is shown, wherever it stands in the alphabet.
    assert "✗ BROKEN" in card(reader, "result599")


def test_a_page_is_made_anew_and_another_file_is_left_alone(tmp_path):
    cases.good(tmp_path)
    path = report.page(tmp_path)
    path.chmod(0o600)
    before = path.read_bytes()
    path.write_bytes(before.replace(b"How far off?", b"How far on?"))
    assert report.page(str(tmp_path)) == path
    assert b"How far on?" not in path.read_bytes()
    assert path.stat().st_mode & 0o777 == 0o600
    for own in ("<!DOCTYPE html><title>My own</title>", "", "\0\xff", "x" * 5000 + before.decode()):
        path.write_text(own)
        with pytest.raises(
            InvalidValue, match=r"index\.html: is not a page of results: move it, or choose another folder"
        ):
            report.page(tmp_path)
        assert path.read_text() == own


def test_a_folder_without_results_is_refused(tmp_path):
    (tmp_path / "mine").mkdir()
    with pytest.raises(InvalidValue, match="holds no results; diffdrive experiment mismatched_radii makes some"):
        report.page(tmp_path)
    with pytest.raises(MissingFile, match="no such folder of results"):
        report.page(tmp_path / "nowhere")
    with pytest.raises(InvalidType, match="folder = 3: must be a path"):
        report.page(3)
    assert list(tmp_path.iterdir()) == [tmp_path / "mine"]


def test_a_failed_write_leaves_no_page(tmp_path, monkeypatch):
    cases.good(tmp_path)
    monkeypatch.setattr(
        "pathlib.Path.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device"))
    )
    with pytest.raises(InvalidValue, match=r"index\.html: cannot be written \(No space left on device\)"):
        report.page(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bend", "other"]


def test_the_command_writes_the_page_and_says_where(tmp_path, monkeypatch, capsys):
    cases.good(tmp_path / "results")
    monkeypatch.chdir(tmp_path)
    cli.main(["report"])
    assert capsys.readouterr().out == "page: results/index.html\n"
    cli.main(["report", str(tmp_path / "results")])
    assert capsys.readouterr().out == f"page: {tmp_path}/results/index.html\n"


@pytest.mark.parametrize("make", ["nothing", "empty", "foreign", "file"])
def test_the_command_refuses_in_one_line(tmp_path, capsys, make):
    folder = tmp_path / "results"
    if make == "file":
        folder.write_text("")
    elif make != "nothing":
        folder.mkdir()
    if make == "foreign":
        (folder / "index.html").write_text("my own")
    with pytest.raises(SystemExit) as ended:
        cli.main(["report", str(folder)])
    said = capsys.readouterr()
    assert (ended.value.code, said.out, said.err.count("\n")) == (2, "", 1)
    assert said.err.startswith(f"diffdrive: {folder}")


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may write anywhere")
def test_a_folder_that_is_read_only_is_one_line(tmp_path, capsys):
    cases.good(tmp_path)
    tmp_path.chmod(0o500)
    with pytest.raises(SystemExit):
        cli.main(["report", str(tmp_path)])
    assert "index.html: cannot be written (Permission denied)" in capsys.readouterr().err


def test_rooms_are_shared_and_never_overdrawn():
    rng = np.random.default_rng(1)
    room = Room(10_000, 30, least=900, most=2_000)
    shares = []
    for _ in range(30):
        shares.append(room.share())
        room.take(int(shares[-1] * rng.uniform(0.5, 1.0)))
    assert room.left >= 0
    assert set(shares[:5]) == {900}
    assert shares[-1] == 0
    assert Room(10_000, 2, least=900, most=2_000).share() == 2_000


@pytest.mark.parametrize("text", ["short", "<&>" * 50, "ü" * 100, "a" * 99 + "<", ""])
def test_escaped_text_keeps_its_length(text):
    for most in (0, 20, 40, 103, 400, 1000):
        said = escaped(text, most)
        assert len(said.encode()) <= max(most, len(" … (cut short)".encode()))
        assert said == html.escape(text) or said.endswith(" … (cut short)")
        assert (said == html.escape(text)) is (len(html.escape(text).encode()) <= most)
        assert (
            html.unescape(said.removesuffix(" … (cut short)"))
            == text[: len(html.unescape(said)) - 14 * (said[-1:] == ")")]
        )


def test_nothing_in_a_scripts_data_can_end_it():
    said = in_script({cases.HOSTILE: [cases.HOSTILE]})
    assert not set("<>&") & set(said)
    assert json.loads(said) == {cases.HOSTILE: [cases.HOSTILE]}


def test_a_page_is_small_and_quick_whatever_a_list_claims(tmp_path):
    """One picture named over and over, notes and bounds without end, names of any length."""
    for k in range(220):
        place = tmp_path / f"{'<&' * 60}{k}"
        place.mkdir()
        bounds = [{"name": "<'>" * 500, "value": 2.0, "limit": 1.0, "unit": "&" * 500}] * 20
        names = ["a.png"] * 500 + [f"{'&' * 100}{n}.png" for n in range(50)]
        (place / "metrics.json").write_text(cases.listing(question="&" * 5000, bounds=bounds, pictures=names))
        Image.new("RGB", (4, 3), "red").save(place / "a.png")
    reader = read(tmp_path)
    assert len(reader.all("img")) >= 50
    ((summary, _),) = reader.all("p", **{"class": "summary"})
    assert summary.startswith("220 questions asked; 0 of 4400 bounds hold; 4400 broken, in ")
    assert " results are left out" in summary
    assert "more faults like these" in "".join(text for text, _ in reader.all("p", **{"class": "note"}))


def test_a_locked_folder_has_a_card_that_says_so(tmp_path, monkeypatch):
    cases.good(tmp_path)
    (tmp_path / "locked").mkdir()
    exists = type(tmp_path).exists
    denied = PermissionError(13, "Permission denied")

    def locked(path, **options):
        if path.parent.name == "locked":
            raise denied
        return exists(path, **options)

    monkeypatch.setattr(type(tmp_path), "exists", locked)
    reader = read(tmp_path)
    assert "cannot be read (Permission denied)" in card(reader, "locked")
    assert "How far off?" in card(reader, "bend")
