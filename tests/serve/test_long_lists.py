import threading

import pytest

from hcsearch.basics.errors import QueryError
from hcsearch.web.serve.jobs import BusyError

pytestmark = pytest.mark.extra


@pytest.fixture
def lists():
    from hcsearch.web.serve.listing import LongLists

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
    from hcsearch.web.serve.listing import LongLists

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
    from hcsearch.web.serve.listing import LongLists

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
