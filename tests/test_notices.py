"""Notices are logged, and collected in order, each once."""

from recon.notices import collected_notices, notify


def test_notices_are_collected_once_and_in_order(caplog):
    with collected_notices() as notices:
        notify("rows-differ", "rows differ by 2 px")
        notify("box-empty", "nothing lies in the box")
        notify("rows-differ", "rows differ by 2 px")
    assert [notice.code for notice in notices] == ["rows-differ", "box-empty"]
    assert notices[0].as_json() == {"code": "rows-differ", "text": "rows differ by 2 px"}
    assert len(caplog.records) == 2


def test_notice_outside_a_collection_is_only_logged(caplog):
    with collected_notices() as notices:
        pass
    notify("box-empty", "nothing lies in the box")
    assert notices == []
    assert "box-empty" in caplog.text
