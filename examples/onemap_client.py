#!/usr/bin/env python3
"""A client of onemapd's control socket (onemap-control.7): JSON objects, one a line, each with a "class".

  onemap_client.py SOCKET            the robot's status in a line, then ten poses as they come
"""
import json
import socket
import sys


class Onemap:
    PROTOCOL = 1

    def __init__(self, path, timeout_s=10.0):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(timeout_s)
        self._socket.connect(path)
        self._lines = self._socket.makefile("r", encoding="utf-8", newline="\n")
        self.version = self.receive()
        if self.version["class"] != "VERSION" or self.version["protocol"] != self.PROTOCOL:
            raise RuntimeError(f"{path} speaks {self.version}, not protocol {self.PROTOCOL}")

    def send(self, name, **keys):
        self._socket.sendall((json.dumps({"class": name, **keys}) + "\n").encode())

    def receive(self):
        """The next object; the daemon's end is an EOFError."""
        line = self._lines.readline()
        if not line:
            raise EOFError("the daemon closed the connection")
        return json.loads(line)

    def ask(self, name, **keys):
        """The answer to a request; long jobs are waited for, what is watched is passed over."""
        self.send(name, id=name, **keys)
        while True:
            answer = self.receive()
            if answer["class"] == "ERROR":
                raise RuntimeError(answer["message"])
            if answer.get("id") == name and answer["class"] != "ACK":
                return answer

    def watch(self, *classes):
        """Yields objects of these classes (POSE, EVENT, PEERS, STATUS) as they come."""
        self.ask("WATCH", classes=list(classes))
        while True:
            yield self.receive()


def main():
    robot = Onemap(sys.argv[1])
    status = robot.ask("STATUS")
    print(f"{status['robot']}: {status['state']}, {status['tracked']} of {status['frames']} frames placed")
    for number, pose in enumerate(robot.watch("POSE"), start=1):
        print(pose["time_s"], "tracked" if pose["tracking"] else "lost", *pose["T_odom_camera"])
        if number == 10:
            break


if __name__ == "__main__":
    main()
