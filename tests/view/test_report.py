"""The report is one valid page, stands alone and says what happened."""

import json
import os
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.joints import JOINTS
from mobius.view.report import build_report, verdict, write_report
from mobius.view.sections import close_up, energy_J

VOID = {"meta", "img", "br", "hr", "link", "input"}


class Checker(HTMLParser):
    """Raises where a tag is closed that is not the last one opened."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.ids, self.addresses, self.seen = [], [], [], set()

    def handle_starttag(self, name, attributes):
        given = dict(attributes)
        self.seen.add(name)
        self.ids += [given["id"]] if "id" in given else []
        self.addresses += [given[k] for k in ("src", "href") if k in given]
        if name not in VOID:
            self.open.append(name)

    def handle_endtag(self, name):
        assert self.open and self.open[-1] == name, f"</{name}> closes {self.open[-3:]}"
        self.open.pop()


def check(page):
    checker = Checker()
    checker.feed(page)
    checker.close()
    assert checker.open == []
    assert len(set(checker.ids)) == len(checker.ids)
    return checker


@pytest.fixture(scope="module")
def page(make_record, make_occupancy):
    return build_report(
        make_record(),
        occupancy=make_occupancy(np.eye(40, dtype=bool)),
        still=np.full((54, 96, 3), 90, dtype=np.uint8),
        files=("video.mp4", "run.mcap"),
    )


def test_every_tag_is_closed_in_order_and_the_page_has_its_parts(page):
    seen = check(page).seen
    assert page.startswith("<!DOCTYPE html>")
    assert {"html", "head", "title", "main", "h1", "h2", "svg", "table", "figure"} <= seen


def test_nothing_is_fetched_from_anywhere(page):
    addresses = check(page).addresses
    assert {a for a in addresses if not a.startswith("data:image/")} == {"video.mp4", "run.mcap"}
    for outside in ("http", "//cdn", "@import", "url(", "<link"):
        assert outside not in page.lower()


def test_no_placeholder_is_left_in_the_page(page):
    assert not re.search(r"\$(title|body|track)", page)
    assert "$$" not in page


def test_the_page_opens_with_a_verdict(page):
    text = re.search(r'<p class="verdict good">([^<]*)</p>', page).group(1)
    assert text == (
        "Reached the goal, 0.12 m from it after 20.0 s and 6.00 m of path,"
        " with no falls and 1 wall contact."
    )


def test_every_section_and_every_joint_is_there(page):
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    assert headings == ["Way", "Velocity", "Estimator", "Gait", "Effort", "All numbers"]
    for joint in JOINTS:
        assert f">{joint.replace('_', ' ')}</text>" in page


def test_every_number_of_the_summary_is_in_the_table_with_its_unit(page):
    table = re.search(r"<table>(.*)</table>", page).group(1)
    rows = dict(re.findall(r"<tr><th>([^<]*)</th><td>([^<]*)</td></tr>", table))
    assert rows["final distance"] == "0.120 m"
    assert rows["energy per cell"] == "81.2 J"
    assert rows["estimator velocity rmse"] == "0.0200 m/s"
    assert rows["plan solve"] == "12.3 ms"
    assert rows["versions mujoco"] == "4.0.0"
    assert rows["seed"] == "7"
    assert len(rows) == 21


def test_the_moving_arrow_is_told_time_and_place(page, record):
    track = json.loads(re.search(r'id="track">([^<]*)</script>', page).group(1))
    assert len(track) <= 1000
    t, x, y, _, _, _ = track[0]
    np.testing.assert_allclose([t, x, y], [0.0, *record.true_p[0, :2]], atol=1e-3)


def test_a_name_that_is_markup_stays_a_name(record):
    record.grid = replace(record.grid, name="<script>alert(1)<b>$body")
    page = build_report(record)
    check(page)
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;b&gt;$body" in page


@pytest.mark.parametrize(
    ("summary", "good", "said"),
    [
        (
            {"goal_reached": False, "final_distance_m": 2.345, "falls": 1, "collisions": 0},
            False,
            "Did not reach the goal: 2.3 m short, with 1 fall and no wall contacts.",
        ),
        (
            {"goal_reached": True, "final_distance_m": 0.1, "falls": 2},
            False,
            "Reached the goal, 0.10 m from it, with 2 falls and no wall contacts.",
        ),
        ({}, False, "The run left no verdict: its summary lacks goal_reached, falls,"),
    ],
)
def test_the_verdict_is_good_only_without_falls_at_the_goal(summary, good, said):
    found, sentence = verdict(summary)
    assert found is good
    assert sentence.startswith(said)


def test_a_map_that_is_a_path_is_called_by_its_file(record):
    record.grid = replace(record.grid, name="/some/where/maps/depot.yaml")
    assert "<h1>MOBIUS on depot.yaml</h1>" in build_report(record)
    record.summary["map"] = "depot"
    assert "<h1>MOBIUS on depot</h1>" in build_report(record)


def test_what_the_summary_lacks_is_shown_as_lacking(record):
    record.summary = {}
    page = build_report(record)
    check(page)
    assert "seed not recorded" in page
    assert "<b>\u2013</b>" in page


def test_a_run_of_ten_minutes_stays_small_enough_to_mail(make_record):
    page = build_report(make_record(600.0))
    check(page)
    assert len(page.encode()) < 3_000_000


def test_two_samples_are_enough_and_one_is_refused(record):
    arrays = {k: v[:2] for k, v in vars(record).items() if isinstance(v, np.ndarray)}
    check(build_report(replace(record, modes=record.modes[:2], **arrays)))
    one = {k: v[:1] for k, v in arrays.items()}
    with pytest.raises(InvalidInput, match="two samples or more, got 1"):
        build_report(replace(record, modes=record.modes[:1], **one))


def test_the_same_run_gives_the_same_page(record):
    assert build_report(record) == build_report(record)


def test_the_page_is_written_whole_and_alone(record, tmp_path):
    write_report(tmp_path / "report.html", record, title="A run")
    assert os.listdir(tmp_path) == ["report.html"]
    assert "<h1>A run</h1>" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_energy_is_the_integral_of_power_by_trapezoids(record):
    two = replace(record, t=np.array([0.0, 1.0, 3.0]), power=np.array([2.0, 4.0, 1.0]))
    # 1 s * (2 + 4) / 2 = 3;  2 s * (4 + 1) / 2 = 5
    assert energy_J(two).tolist() == [0.0, 3.0, 8.0]


def test_the_close_up_is_four_seconds_of_motion(record):
    command = np.zeros_like(record.cmd_twist_H)
    command[(record.t >= 10) & (record.t < 16), 0] = 0.2
    rows = close_up(replace(record, cmd_twist_H=command))
    # the middle of the motion is 13 s
    np.testing.assert_allclose(record.t[rows[[0, -1]]], [11.0, 15.0], atol=0.03)
