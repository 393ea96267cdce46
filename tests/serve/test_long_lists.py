import threading

import pytest

from hcsearch.errors import QueryError
from hcsearch.serve.computing import BusyError

pytestmark = pytest.mark.extra


@pytest.fixture
def lists():
    from hcsearch.serve.long_lists import LongLists

    return LongLists(most=1, waiting=1, short=0.1, seconds=5.0)


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
