"""What a worker process does: it answers calls. Loads nothing else, so that what cannot be loaded is an answer, too."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from multiprocessing.connection import Connection


def answer_calls(requests: Connection) -> None:
    """Answer calls until there are no more; leave Ctrl-C to the process that started this one, and end with it.

    A call comes with its arguments; the answer is whether it was good, and its result or its exception.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    try:
        while True:
            request = requests.recv_bytes()
            try:
                call, arguments, options = pickle.loads(request)
                reply = pickle.dumps((True, call(*arguments, **options)))
            except Exception as error:
                reply = pickle.dumps((False, _to_be_sent(error)))
            requests.send_bytes(reply)
    except (EOFError, ConnectionError):
        return  # nobody asks any more


def raising_place_of(error: BaseException) -> str:
    """The line in which an exception was raised, with its module; that in a worker process if it came from there."""
    at_worker = getattr(error, "place", None)
    if isinstance(at_worker, str):
        return at_worker
    where = error.__traceback__
    while where is not None and where.tb_next is not None:
        where = where.tb_next
    return "" if where is None else f"{where.tb_frame.f_globals.get('__name__')}:{where.tb_lineno}"


def _to_be_sent(error: Exception) -> Exception:
    """The exception with its place and its traceback, which are not pickled; a plain one where it cannot be pickled."""
    error.add_note(f"in a worker process:\n{traceback.format_exc()}")
    error.__dict__["place"] = raising_place_of(error)
    try:
        if type(pickle.loads(pickle.dumps(error))) is type(error):
            return error
    except Exception:  # of what the exception holds, or of the way it is made
        pass
    plain = RuntimeError(f"{type(error).__name__}: {error}")
    plain.__dict__.update({"place": raising_place_of(error), "__notes__": error.__notes__})
    return plain
