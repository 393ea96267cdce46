import threading
import time

import pytest

from hcsearch.basics.errors import DatabaseError, QueryError
from hcsearch.web.serve.jobs import BusyError

pytestmark = pytest.mark.extra


@pytest.fixture
def lists():
    from hcsearch.web.serve.long_lists import LongLists

    return LongLists(max_long_lists=1, waiting=1, short=0.1, seconds=5.0)


def slow(seconds):
    from hcsearch.store import SlowQueryError

    raise SlowQueryError(f"more than {seconds} s")


def test_what_is_quick_is_asked_once(lists):
    asked = []
    assert lists(lambda seconds: asked.append(seconds) or "rows") == "rows"
    assert asked == [0.1]


def test_what_takes_longer_is_asked_again_with_all_the_time(lists):
    assert lists(lambda seconds: slow(seconds) if seconds < 1 else seconds) == 5.0


def test_what_takes_too_long_says_how_long(lists):
    for _ in range(3):  # each gives back its turn
        with pytest.raises(QueryError, match="takes more than 5 s here"):
            lists(slow)


def test_a_turn_is_given_back_after_any_error(lists):
    def fails(seconds):
        if seconds < 1:
            slow(seconds)
        raise RuntimeError("a fault")

    for _ in range(3):
        with pytest.raises(RuntimeError):
            lists(fails)
    assert (lists._turns._value, lists._room._value) == (1, 2)


def test_who_waits_in_vain_is_refused_and_leaves_the_others_their_turns():
    from hcsearch.web.serve.long_lists import LongLists

    lists = LongLists(max_long_lists=1, waiting=1, short=0.01, seconds=0.1)
    assert lists._turns.acquire()
    with pytest.raises(BusyError, match="try again in a few seconds"):
        lists(slow)
    lists._turns.release()
    assert lists(lambda seconds: slow(seconds) if seconds < 0.1 else "rows") == "rows"
    assert (lists._turns._value, lists._room._value) == (1, 2)


def test_beyond_its_room_a_long_list_is_refused_and_a_quick_one_answered(lists):
    begun, go_on, given = threading.Semaphore(0), threading.Event(), []

    def long(seconds):
        if seconds < 1:
            begun.release()
            slow(seconds)
        go_on.wait(20)
        return "long"

    threads = [threading.Thread(target=lambda: given.append(lists(long))) for _ in range(2)]
    for thread in threads:
        thread.start()
        assert begun.acquire(timeout=20)
    while lists._room._value:  # both are past their first look
        assert lists(lambda _seconds: "quick") == "quick"
    with pytest.raises(BusyError, match="takes long, and so do others"):
        lists(long)
    assert lists(lambda _seconds: "quick") == "quick"
    go_on.set()
    for thread in threads:
        thread.join(20)
    assert given == ["long", "long"]


@pytest.mark.parametrize("address", ["/designs", "/designs?as=table", "/designs.json?limit=2", "/foldings.csv?page=1"])
def test_a_long_list_without_room_is_answered_with_when_to_ask_again(asking, monkeypatch, address):
    from hcsearch.web.serve import downloads, listing
    from hcsearch.web.serve.long_lists import LongLists

    def taking_long(ask):
        return lambda *given: slow(given[-1]) if given[-1] < 1 else ask(*given)

    expected = asking(address)
    monkeypatch.setattr(listing, "list_page_of", taking_long(listing.list_page_of))
    monkeypatch.setattr("hcsearch.web.serve.application.text_of_few_rows", taking_long(downloads.text_of_few_rows))
    monkeypatch.setattr(asking.application, "_long_lists", LongLists(max_long_lists=0, waiting=0))
    answer = asking(address)
    assert (answer.status, int(answer.headers["Retry-After"])) == (503, 5)
    assert "this list takes long, and so do others right now" in answer.text
    monkeypatch.setattr(asking.application, "_long_lists", LongLists(max_long_lists=1, waiting=0))
    assert [asking(address).body for _ in range(2)] == [expected.body] * 2


@pytest.fixture
def overviews(asking, monkeypatch):
    """The module, with nothing kept so far."""
    from hcsearch.web.serve import overviews

    monkeypatch.setattr(asking.application, "_overviews", overviews.Overviews())
    return overviews


def test_counts_above_a_list_share_one_time_limit_in_a_turn(asking, monkeypatch, overviews):
    """A list whose counts are slow comes without them, and they are not tried again for a while."""
    given = []

    def summary(*_arguments, seconds):
        given.append(seconds)
        slow(seconds)

    lead = 'class="lead"'
    with monkeypatch.context() as patch:
        patch.setattr(overviews, "summarize", summary)
        assert [lead in asking("/designs").text for _ in range(2)] == [False, False]
    first, full = given
    assert first <= 0.3 < full <= overviews.OVERVIEW_SECONDS
    assert lead not in asking("/designs").text
    now = time.monotonic()
    monkeypatch.setattr(overviews.time, "monotonic", lambda: now + overviews.SLOW_OVERVIEW_SECONDS + 1)
    assert lead in asking("/designs").text


def test_each_count_gets_the_time_that_those_before_it_leave(asking, monkeypatch, overviews):
    from hcsearch.web.serve.long_lists import LongLists

    given = []

    def noting(ask):
        def call(*arguments, seconds):
            given.append(seconds)
            return ask(*arguments, seconds=seconds)

        return call

    monkeypatch.setattr(overviews, "summarize", noting(overviews.summarize))
    monkeypatch.setattr(overviews, "count_values", noting(overviews.count_values))
    monkeypatch.setattr(asking.application, "_long_lists", LongLists(short=60.0))
    assert 'class="lead"' in asking("/designs").text
    assert len(given) > 2
    assert given == sorted(given, reverse=True)
    assert given[0] <= 60.0


def test_counts_without_a_turn_or_from_a_damaged_database_are_tried_again(asking, monkeypatch, overviews):
    from hcsearch.web.serve.long_lists import LongLists

    def damaged(*_arguments, seconds):
        raise DatabaseError("damaged")

    with monkeypatch.context() as patch:
        patch.setattr(overviews, "summarize", damaged)
        assert 'class="lead"' not in asking("/designs").text
    with monkeypatch.context() as patch:
        patch.setattr(overviews, "summarize", lambda *_arguments, seconds: slow(seconds))
        patch.setattr(asking.application, "_long_lists", LongLists(max_long_lists=0, waiting=0, short=5.0))
        answer = asking("/designs")
        assert (answer.status, 'class="lead"' in answer.text) == (200, False)
    assert 'class="lead"' in asking("/designs").text
