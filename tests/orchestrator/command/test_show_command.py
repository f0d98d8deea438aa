"""`macrostep show` as a person types it."""

from __future__ import annotations


def test_show_of_something_that_is_no_run_is_refused(macrostep, in_tmp_path):
    code, _, err = macrostep("show", "nowhere")
    assert (code, "nowhere: found no such file or folder; valid: a run folder, or an .rrd file" in err) == (2, True)
