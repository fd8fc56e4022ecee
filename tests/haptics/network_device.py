"""A device on a UDP socket, written from PROTOCOL.md alone: `network_device.py PORT TRACE SECRET`.

Standard library only, nothing of Dimple: another maker's device can be one. Its fingertips stand still.
It ends when its standard input closes, and writes a row a tick: time [s], mode, largest force [mN], session.
"""

import hashlib
import hmac
import random
import secrets
import select
import socket
import struct
import sys
import time
import zlib

IDLE, ARMING, RAMP, ARMED, BRAKE, FAULT = range(6)
STATE, CMD, HELLO, INFO, ARM, DISARM, _, FAULT_FRAME = range(0x11, 0x19)
TICK = 0.001


def stuffed(payload: bytes) -> bytes:
    block = payload + struct.pack("<I", zlib.crc32(payload))
    out, run = bytearray(), bytearray()
    for byte in block + b"\0":
        if byte:
            run.append(byte)
        else:
            out.append(len(run) + 1)
            out += run
            run.clear()
    return bytes(out) + b"\0"


def unstuffed(code: bytes) -> bytes | None:
    out, at = bytearray(), 0
    while at < len(code):
        length = code[at]
        out += code[at + 1 : at + length] + b"\0"
        at += length
    block = bytes(out[:-1])
    if len(block) < 5 or struct.unpack("<I", block[-4:])[0] != zlib.crc32(block[:-4]):
        return None
    return block[:-4]


class Device:
    def __init__(self, port: int, secret: str) -> None:
        self.key = hashlib.blake2s(secret.encode()).digest()
        self.own, self.other, self.count, self.newest, self.spoken = secrets.token_bytes(8), bytes(8), 0, {}, -1.0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.host = None
        self.mode, self.session, self.seq, self.ack = IDLE, 0, 0, 0
        self.force, self.flags, self.heard = [0] * 9, 0, -1.0
        self.since = self.quiet = 0.0

    def send(self, payload: bytes) -> None:
        if self.host:
            self.count += 1
            datagram = self.other + self.own + struct.pack("<Q", self.count) + stuffed(payload)
            try:
                self.socket.sendto(datagram + self.mac(datagram), self.host)
            except OSError:
                pass

    def mac(self, data: bytes) -> bytes:
        return hashlib.blake2s(data, digest_size=16, key=self.key).digest()

    def hear(self, datagram: bytes, sender: tuple[str, int], now: float) -> None:
        body = datagram[:-16]
        if len(body) < 24 or not hmac.compare_digest(self.mac(body), datagram[-16:]):
            return
        to, other, count = struct.unpack_from("<8s8sQ", body)
        if to != self.own and (any(to) or now - self.spoken < 0.3):
            return
        if count <= self.newest.get(other, 0):
            return
        self.newest[other], self.other, self.host, self.spoken = count, other, sender, now
        for piece in body[24:].split(b"\0"):
            frame = unstuffed(piece) if piece else None
            if frame and (any(to) or frame[0] == HELLO):
                self.take(frame, now)

    def take(self, frame: bytes, now: float) -> None:
        kind = frame[0]
        if kind == HELLO:
            (nonce,) = struct.unpack_from("<H", frame, 1)
            self.session = (self.session + 1) & 0xFF
            self.mode, self.force, self.flags = IDLE, [0] * 9, 0
            numbers = (nonce, 2, 0, self.session, 3, 1000, 5, 25, 100, 1000, 400, 15, 200)
            self.send(struct.pack("<BHBBBBHBBBHHBH", INFO, *numbers))
        elif frame[1] != self.session:
            return
        elif kind == CMD:
            _, _, self.ack, _, *rest = struct.unpack("<BBHH9hBB", frame)
            self.force, self.flags, self.heard = rest[:9], rest[9], now
            if self.flags & 4 and self.mode == FAULT:
                self.mode = IDLE
        elif kind == ARM and self.mode == IDLE:
            self.mode, self.since, self.quiet = ARMING, now, now
        elif kind == DISARM and self.mode != FAULT:
            self.mode = IDLE

    def tick(self, now: float) -> int:
        """Return the largest part of the forces that act [mN]."""
        held, age = self.flags & 3 == 3, now - self.heard
        if self.mode == ARMING:
            if not held or max(map(abs, self.force)) > 0:
                self.quiet = now
            if now - self.quiet >= 0.05:
                self.mode, self.since = RAMP, now
            elif now - self.since > 1.0:
                self.mode = IDLE
                self.send(struct.pack("<BBBBH", FAULT_FRAME, self.session, 4, 255, self.seq))
        elif self.mode in (RAMP, ARMED):
            if age > 0.1:
                self.mode = FAULT
                self.send(struct.pack("<BBBBH", FAULT_FRAME, self.session, 1, 255, self.seq))
            elif not held:
                self.mode, self.since = RAMP, now
            elif now - self.since >= 0.5:
                self.mode = ARMED
        self.seq = (self.seq + 1) & 0xFFFF
        words = [random.randint(-3, 3) for _ in range(9)]  # a fingertip at rest: 30 um of noise
        head = STATE, self.session, self.seq, self.ack, int(now * 1e6) & 0xFFFFFFFF
        self.send(struct.pack("<BBHHI9hBB", *head, *words, 0, self.mode))
        if self.mode not in (RAMP, ARMED) or not held or age > 0.025:
            return 0
        gain = 1.0 if self.mode == ARMED else (now - self.since) / 0.5
        return round(max(map(abs, self.force)) * gain * min((0.025 - age) / 0.020, 1.0))


def main() -> None:
    device, rows, due = Device(int(sys.argv[1]), sys.argv[3]), [], time.perf_counter()
    print("ready", flush=True)
    while True:
        ready = select.select([device.socket, sys.stdin], [], [], max(due - time.perf_counter(), 0.0))[0]
        now = time.perf_counter()
        if sys.stdin in ready and not sys.stdin.buffer.read1(64):
            break
        while True:
            try:
                data, sender = device.socket.recvfrom(2048)
            except OSError:
                break
            device.hear(data, sender, now)
        if now >= due:
            due = max(due + TICK, now - 0.01)
            rows.append(f"{now},{device.mode},{device.tick(now)},{device.session}\n")
    with open(sys.argv[2], "w") as file:
        file.writelines(rows)


if __name__ == "__main__":
    main()
