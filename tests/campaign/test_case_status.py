"""Where cases stand, by files and logs: share and time by what is made, what runs and what failed."""

import json
import os
import random

import pytest

from craftmesh.campaign import case_status
from craftmesh.campaign.case_status import case_statuses, jobs
from craftmesh.campaign.job_resources import UNKNOWN
from craftmesh.report.case_files import STAGES, write_records

GROWS = {
    "campaign": "s.tsv",
    "microstructure": "synthetic",
    "cracks": ["a"],
    "increments": 2,
    "growth": "grow",
}
PRESCRIBED = GROWS | {"microstructure": "v.npz", "growth": "prescribed"}
RENEWED = PRESCRIBED | {"config": {"renew": {"reuse": "auto"}}}
ERROR = "craftmesh: error: no room\n"


def begin(results, record, case="one"):
    (results / case).mkdir(parents=True)
    (results / case / "case.json").write_text(json.dumps(record))


def say(results, job, text=""):
    log = results / "logs" / "one" / job.increment / f"{job.name}.log"
    log = log.with_suffix("") / "1-of-2.log" if job.name == "tets" else log
    log.parent.mkdir(parents=True, exist_ok=True)
    log.write_text(text)
    return log


def make(results, job, ended="", seconds=2.0):
    """Make the files of a job, its log, and the time that it took."""
    say(results, job)
    path = results / "one" / job.increment / STAGES[job.name].made
    path.parent.mkdir(exist_ok=True)
    if job.name == "tets":
        for part in (1, 2):
            path.mkdir(exist_ok=True)
            (path / f"{part}-of-2.npz").touch()
    else:
        path.write_text(json.dumps({"ended": ended}))
    took = results / "benchmarks" / "one" / job.increment / f"{job.name}.tsv"
    took.parent.mkdir(parents=True, exist_ok=True)
    took.write_text(f"s\tcpu_time\tmax_rss\n{seconds}\t{seconds}\t100\n")


def test_renewed_increments_have_no_surfaces_of_their_own():
    found = [(job.increment, job.name) for job in jobs(RENEWED, 2)]
    assert ("000", "gradated") in found and ("001", "gradated") not in found
    assert ("001", "sizing") in found and ("001", "renewed") in found
    assert ("001", "volume") not in found and ("000", "renewed") not in found
    assert [job.stage for job in jobs(RENEWED, 2) if job.name == "renewed"] == ["renew"]


@pytest.mark.parametrize("record", [GROWS, PRESCRIBED, RENEWED])
def test_each_job_that_is_made_adds_to_the_share_until_all_is(tmp_path, record):
    begin(tmp_path, record)
    shares = []
    for job in jobs(record, 2):
        (one,) = case_statuses(tmp_path)
        assert one.job == job and not one.runs
        shares.append(one.share)
        make(tmp_path, job)
    assert shares[0] == 0 and shares == sorted(set(shares))
    (one,) = case_statuses(tmp_path)
    assert one.job is None and one.share == 1 and one.left == 0 and str(one) == "one: all is made"


def test_the_share_of_a_stage_is_that_of_its_log(tmp_path):
    begin(tmp_path, GROWS)
    *first, stitch = list(jobs(GROWS, 2))[:6]
    for job in first:
        assert case_statuses(tmp_path)[0].left is None  # nobody knows yet how large it is
        make(tmp_path, job)
    before = case_statuses(tmp_path)[0]
    say(tmp_path, stitch, "stitch  40% cut (12 s)\nstitch  50% patch (22 s)\n")
    now = case_statuses(tmp_path)[0]
    assert now.runs and now.job == stitch and before.share < now.share
    assert 0 < now.left < before.left
    assert str(now).startswith("one: increment 000 (1 of at most 2), stitch, ")


@pytest.mark.parametrize("slower", [0.5, 1.0, 6.0])
def test_the_time_left_is_within_a_factor_once_the_machines_pace_is_measured(tmp_path, slower, monkeypatch):
    sizes = UNKNOWN[".vtu"]
    monkeypatch.setattr(case_status, "_sizes", lambda *_: sizes)
    record = PRESCRIBED | {"increments": 3}
    begin(tmp_path, record)
    off = random.Random(1)  # the plan's estimate of a stage is off by up to a factor
    wrong = {name: off.uniform(0.6, 1.6) for name in STAGES}
    seconds = {
        job: slower * wrong[job.name] * case_status._expected(job.stage, sizes) for job in jobs(record, 3)
    }
    left, rest = {}, sum(seconds.values())
    for job in seconds:
        make(tmp_path, job, seconds=seconds[job])
        rest -= seconds[job]
        left[job] = (case_statuses(tmp_path)[0].left, rest)
    known = [pair for job, pair in left.items() if job.increment and job.name != "crack"][:-1]
    assert all(1 / 1.5 < told / true < 1.5 for told, true in known[:-1])
    after_one = [pair for job, pair in left.items() if job.increment in ("001", "002")][:-1]
    assert [told for told, _ in after_one] == pytest.approx([true for _, true in after_one], rel=1e-6)


def test_a_stages_first_job_which_may_compile_counts_until_the_second(tmp_path):
    record = PRESCRIBED | {"increments": 3}
    left = {}
    for first in (2.0, 2e5):
        folder = tmp_path / str(first)
        begin(folder, record)
        for job in jobs(record, 3):
            make(folder, job, seconds=first if job.increment == "000" else 2.0)
            left[first, job] = case_statuses(folder)[0].left
    second_end = ("001", "pictures")
    assert left[2.0, second_end] == pytest.approx(left[2e5, second_end])


def test_the_pace_is_that_of_all_cases_of_the_folder(tmp_path):
    begin(tmp_path, PRESCRIBED)
    begin(tmp_path, PRESCRIBED, "two")
    for job in list(jobs(PRESCRIBED, 2))[:5]:
        make(tmp_path, job)
    before = case_statuses(tmp_path)[0].left
    slow = tmp_path / "benchmarks" / "two" / "000" / "solution.tsv"
    slow.parent.mkdir(parents=True)
    slow.write_text("s\tcpu_time\tmax_rss\n1e7\t1\t100\n")
    assert case_statuses(tmp_path)[0].left > 10 * before


def test_a_cleaned_case_that_was_copied_is_made(tmp_path):
    begin(tmp_path, PRESCRIBED)
    for job in jobs(PRESCRIBED, 2):
        make(tmp_path, job)
    gradated = next(job for job in jobs(PRESCRIBED, 2) if job.name == "gradated")
    (tmp_path / "one" / "000" / "gradated.vtp").unlink()
    for text, is_made in (("facets 12\n", True), ("gradate  40% collapse (2 s)\n", False), (ERROR, False)):
        os.utime(say(tmp_path, gradated, text), (2e9, 2e9))
        assert (case_statuses(tmp_path)[0].job is None) == is_made


def test_files_after_a_missing_one_are_of_an_earlier_run(tmp_path):
    begin(tmp_path, PRESCRIBED)
    all_jobs = list(jobs(PRESCRIBED, 2))
    for job in all_jobs:
        make(tmp_path, job)
    (tmp_path / "one" / "001" / "sizing.npz").unlink()
    (one,) = case_statuses(tmp_path)
    assert (one.job.increment, one.job.stage) == ("001", "size")
    half = one.share
    (tmp_path / "one" / "000" / "crack.vtp").unlink()
    (one,) = case_statuses(tmp_path)
    assert (one.job.increment, one.job.stage) == ("000", "crack")
    assert 0 < one.share < half  # what was made of 001 still counts


def test_an_error_is_told_unless_it_is_older_than_the_run(tmp_path):
    begin(tmp_path, PRESCRIBED)
    log = say(tmp_path, next(jobs(PRESCRIBED, 2)), ERROR)
    (one,) = case_statuses(tmp_path)
    assert str(one) == "one: failed, one/microstructure.log: no room"
    os.utime(log, (1, 1))
    (one,) = case_statuses(tmp_path, since=2)
    assert not one.failures and not one.runs


def test_a_crack_that_stops_early_is_all_made(tmp_path):
    begin(tmp_path, GROWS)
    for job in jobs(GROWS, 2):
        if job.increment == "001":
            break
        make(tmp_path, job, ended="no K over the threshold")
    assert str(case_statuses(tmp_path)[0]) == "one: stopped, no K over the threshold"


def test_the_share_of_a_crack_that_grows_is_of_all_increments_that_may_come(tmp_path):
    record = GROWS | {"increments": 60}
    begin(tmp_path, record)
    for job in jobs(record, 60):
        if job == ("000", "gradated"):
            break
        make(tmp_path, job)
    (one,) = case_statuses(tmp_path)
    assert str(one).startswith("one: increment 000 (1 of at most 60), gradate waits, 0 %")


def test_only_the_cases_of_the_campaign_are_told(tmp_path):
    begin(tmp_path, GROWS)
    begin(tmp_path, GROWS | {"campaign": "other.tsv"}, "two")
    assert [one.case for one in case_statuses(tmp_path)] == ["one", "two"]
    assert [one.case for one in case_statuses(tmp_path, "other.tsv")] == ["two"]


def test_cases_that_left_the_sheet_do_not_count(tmp_path):
    for case, campaign in (("kept", "s.tsv"), ("gone", "s.tsv"), ("others", "other.tsv")):
        begin(tmp_path, PRESCRIBED | {"campaign": campaign}, case)
    (tmp_path / "gone" / "labels.npz").touch()
    case = {key: PRESCRIBED[key] for key in ("microstructure", "cracks", "growth")}
    case |= {"increments": 1, "settings": {}}
    asked = {"campaign": "s.tsv", "config": {"cracks": {"a": {}}}, "cases": {"kept": case, "new": case}}
    write_records(tmp_path, asked)
    counts = {one.case: one.increments for one in case_statuses(tmp_path)}
    assert counts == {"kept": 1, "new": 1, "others": 2}
    assert (tmp_path / "gone" / "labels.npz").is_file()


def test_the_line_of_a_case_says_where_no_k_is_to_be_trusted(tmp_path):
    begin(tmp_path, GROWS)
    for job in jobs(GROWS, 2):
        make(tmp_path, job)
    found = tmp_path / "one" / "001" / STAGES["fracture"].made
    found.write_text(json.dumps({"growth": {"doubted": [1]}}))
    (one,) = case_statuses(tmp_path)
    assert str(one) == "one: all is made; no reliable K in 001, see report.html"
