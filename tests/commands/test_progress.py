"""Progress lines: in place on a terminal, sparse in a log, nothing for short stages."""

import io

from craftmesh.progress import LiveLines, ProgressLine


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_short_stage_writes_nothing():
    log = io.StringIO()
    with ProgressLine("gradate", log, first=60) as progress:
        progress(0.5, "collapse")
    assert log.getvalue() == ""


def test_log_gets_one_line_per_interval():
    log = io.StringIO()
    progress = ProgressLine("gradate", log, first=0, interval=60)
    progress(0.1, "collapse")
    progress(0.2, "swap")
    progress.close()
    assert log.getvalue() == "gradate  10% collapse (0 s)\n"


def test_terminal_line_is_rewritten_in_place_and_ended():
    terminal = Terminal()
    progress = ProgressLine("remesh", terminal, first=0)
    progress(0.1, "a long text")
    progress.next = 0
    progress(1.0, "end")
    progress.close()
    first, second = terminal.getvalue().split("\r")[1:]
    assert first.startswith("remesh  10%")
    assert second.rstrip() == "remesh 100% end (0 s)" and len(second.rstrip("\n")) >= len(first)
    assert terminal.getvalue().endswith("\n")


def test_lines_of_a_terminal_are_rewritten_in_place_and_taken_away():
    terminal = Terminal()
    with LiveLines(terminal) as lines:
        lines.show(["one", "two"])
        lines.show(["one", "three"])
    assert terminal.getvalue() == "\x1b[Jone\ntwo\n\x1b[2F\x1b[Jone\nthree\n\x1b[2F\x1b[J"


def test_log_gets_the_lines_that_changed():
    log = io.StringIO()
    with LiveLines(log, interval=0) as lines:
        lines.show(["one", "two"])
        lines.show(["one", "three"])
    assert log.getvalue() == "one\ntwo\nthree\n"
