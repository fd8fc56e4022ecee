"""Work in steps: a generator yields the share that is done and returns its result.

One that yields parts, the share that is done and a function to call, is sent what each returns: at once, or beside.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from .base import DimpleError

Parts = Generator[tuple[float, Callable[[], Any]], Any, Any]
LOOK_S = 0.01  # between two looks at a part that is beside

_Result = TypeVar("_Result")


def result_of(steps: Generator[Any, None, _Result]) -> _Result:
    """Run steps to their end and return their result."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found


def as_share(
    steps: Generator[float, None, _Result], done: float, share: float
) -> Generator[float, None, _Result]:
    """Run a part of the work: yield how far the whole is, of which so much was done before and this is such a share."""
    while True:
        try:
            part = next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found
        yield done + share * part


def at_once(parts: Parts) -> Any:
    """Call each part in turn and return the result."""
    send, value = parts.send, None
    while True:
        try:
            _, call = send(value)
        except StopIteration as end:
            return end.value
        try:
            send, value = parts.send, call()
        except DimpleError as error:  # the steps may know what to do about it
            send, value = parts.throw, error


def beside(parts: Parts) -> Generator[float, None, Any]:
    """Call each part in a thread and yield the share that is done meanwhile; once closed, what it still does is lost.

    Returns:
        the result.
    """
    pool, share = ThreadPoolExecutor(1), 0.0

    def waited(call: Callable[[], Any]) -> Generator[float, None, Any]:
        future = pool.submit(call)
        while not future.done():
            time.sleep(LOOK_S)
            yield share
        return future.result()

    send, value = parts.send, None
    try:
        while True:
            try:
                share, call = send(value)
            except StopIteration as end:
                return end.value
            try:
                send, value = parts.send, (yield from waited(call))
            except DimpleError as error:
                send, value = parts.throw, error
    finally:
        parts.close()
        pool.shutdown(wait=False)
