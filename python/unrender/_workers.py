"""One recovery over Dask's workers: the messages, their receivers, and the handling of lost
workers.

Each worker gets a handler by a plugin, which Dask also gives to workers that come later. The driver
sends requests directly to the workers' addresses, one after the other to each; the scheduler only gives
the addresses, so a request takes as long as one message there and one back. The driver can send all data
of a worker again, so any worker may die at any time.
"""

from __future__ import annotations

import asyncio
import hashlib
import itertools
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from . import _unrender
from .errors import RequestError

OP = "unrender_answer"
"""The name of the handler."""

HELD = 12
"""Pieces of shared data that a worker keeps, for all recoveries together: four recoveries with three
each. With half of it, two recoveries on one worker send their scenes again and again; double keeps scenes
of recoveries that have ended for longer."""

REFRESH = 1.0
"""Seconds between two updates of the list of workers: a new worker waits half of that on
average."""

PATIENCE = 60.0
"""Seconds that a recovery waits for a worker when all are lost, before it continues alone. Dask's nanny
restarts a process within some seconds; half of this is too short for a queue of Slurm, double lets users
wait for a cluster that is gone."""

CONNECT = 3.0
"""Seconds that a connection may take. Half of it fails on a loaded network; double waits longer for a
worker that has just died."""

SHUNNED = 5.0
"""Seconds in which an address that failed gets no request: the scheduler may still list it. With double of
it, a worker whose connection broke once is idle for longer; half may wait for a dead one twice."""

PAUSE = 0.1
"""Seconds between two updates of the list while it waits."""


@cache
def build() -> str:
    """SHA-256 of the compiled half, which must be the same on all machines for the same bits."""
    return hashlib.sha256(Path(_unrender.__file__ or "").read_bytes()).hexdigest()


class Holder:
    """The data of a worker: shared data, and prepared scenes."""

    def __init__(self) -> None:
        self._data: OrderedDict[int, bytes] = OrderedDict()
        self._ready: OrderedDict[int, _unrender.Worker] = OrderedDict()
        self._lock = threading.Lock()

    def missing(self, keys: list[int], brought: dict[int, bytes]) -> list[int]:
        """Keeps the data ``brought``; returns which of ``keys`` are missing."""
        with self._lock:
            self._data.update(brought)
            for key in keys:
                if key in self._data:
                    self._data.move_to_end(key)
            while len(self._data) > max(HELD, len(keys)):
                self._data.popitem(last=False)
            return [key for key in keys if key not in self._data]

    def answer(self, keys: list[int], request: bytes) -> bytes:
        """The answer to a request; no data of ``keys`` are missing."""
        with self._lock:
            setup, appearance, seen = (self._data[key] for key in keys)
            worker = self._ready.get(keys[0])
            if worker is None:
                worker = self._ready[keys[0]] = _unrender.Worker(setup)
                while len(self._ready) > HELD // 3:
                    self._ready.popitem(last=False)
        return worker.answer(appearance, seen, request)


HOLDER = Holder()
"""The holder of this process."""


async def handle(
    keys: list[int],
    numbers: list[int],
    values: list[bytes],
    request: bytes,
    build_of_driver: str,
) -> dict[str, Any]:
    """On a worker: the answer to a request, or the data that are missing for it, or the fault."""
    if build_of_driver != build():
        return {"fault": "it has another build of unrender; install the same wheel on all machines"}
    missing = HOLDER.missing(keys, dict(zip(numbers, values, strict=True)))
    if missing:
        return {"missing": missing}
    loop = asyncio.get_running_loop()
    try:
        # Not in the event loop, which handles Dask's messages meanwhile.
        return {"answer": await loop.run_in_executor(None, HOLDER.answer, keys, request)}
    except RequestError as error:
        return {"fault": str(error)}


def plugin() -> Any:
    """The plugin that gives workers the handler."""
    base: Any = import_module("distributed.diagnostics.plugin").WorkerPlugin

    def setup(self: Any, worker: Any) -> None:
        worker.handlers[OP] = handle

    made = type("UnrenderPlugin", (base,), {"name": "unrender", "idempotent": True, "setup": setup})
    return made()


class Lost(Exception):
    """A worker is not ready yet."""


class Workers:
    """The workers of a client, for a recovery."""

    def __init__(self, client: Any, warn: Callable[[str], None]) -> None:
        self._client = client
        self._warn = warn
        self._known: dict[str, set[int]] = {}
        self._failed: dict[str, float] = {}
        self._error: Exception | None = None
        self._looked = 0.0
        self._lock = threading.Lock()
        self._is_over = False
        self._turn = itertools.count()
        self.sent = self.received = self.requests = self.lost = 0
        """Bytes sent, bytes received, requests, and requests whose worker was lost."""
        self._client.register_plugin(plugin())
        self._client.sync(self._look)

    def count(self) -> int:
        """The number of workers; zero once the recovery continues here."""
        return 0 if self._is_over else max(1, len(self._known))

    def answers(self, shared: list[tuple[int, bytes]], requests: list[bytes]) -> list[bytes] | None:
        """The answers to all requests, in their order; None if there are no workers any more."""
        if self._is_over:
            return None
        try:
            found: list[bytes] = self._client.sync(self._answers, shared, requests)
        except Exception as error:
            with self._lock:
                if not self._is_over:
                    self._is_over = True
                    self._warn(f"the recovery continues without its workers: {error}")
            return None
        return found

    async def _look(self) -> None:
        """Updates the list of workers."""
        self._looked = time.monotonic()
        identity = await self._client.scheduler.identity(n_workers=-1)
        shunned = {a for a, when in self._failed.items() if self._looked - when < SHUNNED}
        there = set(identity["workers"]) - shunned
        for address in set(self._known) - there:
            del self._known[address]
        for address in there - set(self._known):
            self._known[address] = set()

    async def _answers(self, shared: list[tuple[int, bytes]], requests: list[bytes]) -> list[bytes]:
        data, keys = dict(shared), [number for number, _ in shared]
        answers: dict[int, bytes] = {}
        waiting = deque(range(len(requests)))

        async def ask(address: str) -> None:
            while waiting:
                index = waiting.popleft()
                try:
                    answers[index] = await self._ask(address, keys, data, requests[index])
                except RequestError:
                    raise
                except Exception as error:
                    # Whatever the error of a dying worker is, another one gets the request.
                    self._error = error
                    self.lost += 1
                    waiting.append(index)
                    self._known.pop(address, None)
                    self._failed[address] = time.monotonic()
                    return

        since = time.monotonic()
        while len(answers) < len(requests):
            if not self._known or time.monotonic() - self._looked > REFRESH:
                await self._look()
            # The first worker of one round is the last of the next: most requests are single.
            there = list(self._known)
            first = next(self._turn) % max(1, len(there))
            before = len(answers)
            await asyncio.gather(*(ask(address) for address in there[first:] + there[:first]))
            if len(answers) > before:
                since = time.monotonic()
            elif time.monotonic() - since > PATIENCE:
                last = f"; the last error was {self._error!r}" if self._error else ""
                raise RequestError(f"no worker answered for {PATIENCE:.0f} s{last}")
            else:
                await asyncio.sleep(PAUSE)
        return [answers[index] for index in range(len(requests))]

    async def _ask(
        self, address: str, keys: list[int], data: dict[int, bytes], request: bytes
    ) -> bytes:
        """The answer of one worker."""
        while True:
            known = self._known.get(address, set())
            brought = [key for key in keys if key not in known]
            values = [data[key] for key in brought]
            self.requests += 1
            self.sent += len(request) + sum(map(len, values))
            message = {
                "keys": keys,
                "numbers": brought,
                "values": values,
                "request": request,
                "build_of_driver": build(),
            }
            reply = await self._send(address, message)
            if reply is None:
                raise Lost("a worker has no handler yet")
            if "fault" in reply:
                raise RequestError(f"worker {address}: {reply['fault']}")
            known.update(brought)
            if "answer" in reply:
                answer: bytes = reply["answer"]
                self.received += len(answer)
                return answer
            known.difference_update(reply["missing"])

    async def _send(self, address: str, message: dict[str, Any]) -> dict[str, Any] | None:
        """The reply of a worker's handler to a message; None if it has no handler."""
        pool = self._client.rpc
        comm = await pool.connect(address, timeout=CONNECT)
        send: Any = import_module("distributed.core").send_recv
        try:
            reply: dict[str, Any] | None = await send(comm, op=OP, **message)
            return reply
        finally:
            pool.reuse(address, comm)
