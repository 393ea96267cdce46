import os
import threading
import time

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.web.serve.jobs import BusyError, ComputingPool, ResultCache


def refused() -> None:
    raise HcsearchError("no such thing: name another")


def dies() -> None:
    os._exit(1)


@pytest.fixture
def computing():
    made = ComputingPool(processes=1, seconds=20.0)
    yield made
    made.close()


def test_results_are_kept_by_their_key_and_refusals_are_not(computing):
    assert computing("a", int, "7") == 7
    assert computing("a", int, "8") == 7
    with pytest.raises(HcsearchError, match="name another"):
        computing("b", refused)
    assert computing("b", os.getpid) != os.getpid()


def test_a_process_that_dies_is_replaced(computing):
    with pytest.raises(BusyError, match="was ended"):
        computing("a", dies)
    assert computing("a", int, "7") == 7


def test_what_takes_too_long_is_ended_and_what_finds_no_room_is_refused_at_once():
    computing = ComputingPool(processes=1)
    computing("warm", int, "7")
    computing._seconds = 3.0  # from here on, as a process takes long to start on a busy machine
    late: list[str] = []

    def compute(key):
        try:
            computing(key, time.sleep, 60)
        except BusyError as error:
            late.append(str(error))

    threads = [threading.Thread(target=compute, args=(key,)) for key in "ab"]
    for thread in threads:
        thread.start()
    while computing._room._value:
        time.sleep(0.01)
    start = time.monotonic()
    with pytest.raises(BusyError, match="right now"):
        computing("c", int, "7")
    assert computing("warm", int, "8") == 7
    assert time.monotonic() - start < 1.0
    for thread in threads:
        thread.join()
    assert any("takes more than 3 s" in message for message in late)
    computing._seconds = 60.0
    assert computing("d", int, "7") == 7
    computing.close()


def test_the_latest_results_are_kept():
    kept = ResultCache(2)
    for key in "abc":
        kept[key] = key.upper()
    with pytest.raises(KeyError):
        kept["a"]
    assert (kept["b"], kept["c"]) == ("B", "C")
