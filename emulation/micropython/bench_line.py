"""The host's line of an emulated board, a socket in place of USB."""

import binascii

import bench


class Line:
    def received(self):
        return bytes(int(each) for each in bench.host_take().split())

    def send(self, frame):
        bench.host_send(binascii.hexlify(frame).decode())

    def close(self):
        pass
