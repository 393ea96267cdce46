"""The main loop of a worker process, which executes calls and sends their results.

Little else is imported here: a module that cannot be imported is then reported as the answer to a call.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from multiprocessing.connection import Connection

from hcsearch.system.work_steps import hearing_work


def answer_calls(requests: Connection) -> None:
    """Execute calls from a pipe until it is closed.

    A request is a function with its arguments; the answer is a flag of success with the result or the exception. Before
    it, each step of the work is sent, with None in place of the flag. SIGINT is ignored, since the parent process
    handles it; the worker ends when its parent does.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    def send_step(words: str, count: int) -> None:
        with sending:
            requests.send_bytes(pickle.dumps((None, (words, count))))

    sending = threading.Lock()  # steps are reported by all threads of a call
    threading.Thread(target=watch, daemon=True).start()
    try:
        while True:
            request = requests.recv_bytes()
            try:
                call, arguments, options = pickle.loads(request)
                with hearing_work(send_step):
                    reply = pickle.dumps((True, call(*arguments, **options)))
            except Exception as error:
                reply = pickle.dumps((False, _to_be_sent(error)))
            with sending:
                requests.send_bytes(reply)
    except (EOFError, ConnectionError):
        return  # the parent has closed the pipe


def raising_place_of(error: BaseException) -> str:
    """Return `module:line` where an exception was raised; in the worker process if it was raised there."""
    at_worker = getattr(error, "place", None)
    if isinstance(at_worker, str):
        return at_worker
    traceback_entry = error.__traceback__
    while traceback_entry is not None and traceback_entry.tb_next is not None:
        traceback_entry = traceback_entry.tb_next
    return (
        ""
        if traceback_entry is None
        else f"{traceback_entry.tb_frame.f_globals.get('__name__')}:{traceback_entry.tb_lineno}"
    )


def _to_be_sent(error: Exception) -> Exception:
    """Return an exception that can be pickled, with its place and traceback attached: a RuntimeError where needed."""
    error.add_note(f"in a worker process:\n{traceback.format_exc()}")
    error.__dict__["place"] = raising_place_of(error)
    try:
        if type(pickle.loads(pickle.dumps(error))) is type(error):
            return error
    except Exception:  # values that cannot be pickled, constructors with other arguments
        pass
    plain = RuntimeError(f"{type(error).__name__}: {error}")
    plain.__dict__.update({"place": raising_place_of(error), "__notes__": error.__notes__})
    return plain
