"""A non-blocking WebSocket client for whole text messages to a device's service on this computer.

Source: RFC 6455.
"""

from __future__ import annotations

import base64
import hashlib
import secrets
import socket
from typing import Final

from ..errors import DimpleError
from .limits import ANSWER_TIME

_GUID: Final = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_CONTINUED, _TEXT, _CLOSE, _PING, _PONG = 0x0, 0x1, 0x8, 0x9, 0xA
LONGEST: Final = 1 << 20  # [bytes] largest message


class WebSocket:
    """An open connection; `read` and `write` raise OSError if it is lost.

    Args:
        number: port on this computer.

    Raises:
        OSError: nothing answers there.
        DimpleError: what answers is not a WebSocket.
    """

    def __init__(self, number: int) -> None:
        self._out = self._parts = b""
        self.socket = socket.create_connection(("127.0.0.1", number), ANSWER_TIME)
        try:
            self._greet(number)
        except BaseException:
            self.socket.close()
            raise
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # send each force at once
        self.socket.setblocking(False)

    def _greet(self, number: int) -> None:
        key = base64.b64encode(secrets.token_bytes(16))
        self.socket.sendall(
            b"GET / HTTP/1.1\r\nHost: localhost:%d\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: %b\r\nSec-WebSocket-Version: 13\r\n\r\n" % (number, key)
        )
        head = b""
        while b"\r\n\r\n" not in head and len(head) < LONGEST and (more := self.socket.recv(4096)):
            head += more
        head, _, self._in = head.partition(b"\r\n\r\n")
        expected = base64.b64encode(hashlib.sha1(key + _GUID).digest())
        if b" 101 " not in head.partition(b"\r\n")[0] + b" " or expected not in head:
            raise DimpleError("Port {number} of this computer is not the port of a device service.", number=number)

    def read(self) -> list[str]:
        """Return the messages that have arrived."""
        while True:
            try:
                data = self.socket.recv(1 << 16)
            except BlockingIOError:
                break
            if not data:
                raise ConnectionResetError("closed")
            self._in += data
        messages = []
        while (frame := self._frame()) is not None:
            kind, last, payload = frame
            if kind == _CLOSE:
                raise ConnectionResetError("closed")
            if kind == _PING:
                self._send(_PONG, payload)
            elif kind in (_TEXT, _CONTINUED):
                self._parts += payload
                if last:
                    messages.append(self._parts.decode(errors="replace"))
                    self._parts = b""
        return messages

    def write(self, message: str) -> bool:
        """Send a message; return False if the one before is still being sent: this one is then dropped."""
        return self._send(_TEXT, message.encode())

    def _frame(self) -> tuple[int, bool, bytes] | None:
        """Return the kind, whether it ends a message, and payload of the next complete frame; None without one."""
        if len(self._in) < 2:
            return None
        size, at = self._in[1] & 0x7F, 2
        if size > 125:
            at += 2 if size == 126 else 8
            size = int.from_bytes(self._in[2:at], "big")
        if size + len(self._parts) > LONGEST:
            raise ConnectionResetError("message too long")
        if len(self._in) < at + size:
            return None
        first, payload = self._in[0], self._in[at : at + size]
        self._in = self._in[at + size :]
        return first & 0x0F, bool(first & 0x80), payload

    def _send(self, kind: int, payload: bytes) -> bool:
        size = len(payload)
        head = bytes((0x80 | kind, 0x80 | size)) if size < 126 else bytes((0x80 | kind, 0xFE)) + size.to_bytes(2, "big")
        if not self._flush():  # no frame may start inside a half-sent one
            return False
        self._out = head + bytes(4) + payload  # a mask of zeros suffices: no proxy is in between
        self._flush()
        return True

    def _flush(self) -> bool:
        """Send what is left of the last frame; return whether nothing is."""
        try:
            self._out = self._out[self.socket.send(self._out) :] if self._out else self._out
        except BlockingIOError:
            pass
        return not self._out
