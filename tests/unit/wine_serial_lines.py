# SPDX-License-Identifier: Zlib
# Runs a program under Wine, for which it makes serial lines without devices.
# Usage: wine_serial_lines.py WINE PROGRAM [ARGUMENT...]
# The program finds a port of the loopback in SERIAL_LINES. Each connection there is the other end of a new serial line. Its name comes
# first, as a line (COM40). When the connection is closed, the serial line hangs up.
import fcntl
import os
import pathlib
import select
import signal
import socket
import subprocess
import sys
import termios
import tty

FIRST_NUMBER = 40  # Wine gives the low ones to the serial lines of the machine


def serve(connection, link):
	# Without a session that it belongs to, a terminal becomes that of the Wine server, which is then told of the hang-up in our place.
	os.setsid()
	signal.signal(signal.SIGHUP, signal.SIG_IGN)
	master, line = os.openpty()
	fcntl.ioctl(line, termios.TIOCSCTTY, 0)
	tty.setraw(line)
	link.unlink(missing_ok=True)
	link.symlink_to(os.ttyname(line))
	try:
		connection.sendall(link.name.upper().encode() + b"\n")
		while True:
			for end in select.select([connection, master], [], [])[0]:
				if end is master:
					connection.sendall(os.read(master, 4096))
					continue
				data = connection.recv(4096)
				if not data:
					return
				os.write(master, data)
	finally:
		link.unlink(missing_ok=True)


def main():
	prefix = pathlib.Path(os.environ.get("WINEPREFIX") or pathlib.Path.home() / ".wine")
	listener = socket.create_server(("127.0.0.1", 0))
	program = subprocess.Popen(sys.argv[1:], env={**os.environ, "SERIAL_LINES": str(listener.getsockname()[1])})
	children = []
	listener.settimeout(0.1)
	while program.poll() is None:
		try:
			connection, _ = listener.accept()
		except TimeoutError:
			continue
		connection.setblocking(True)
		child = os.fork()
		if child == 0:
			listener.close()
			try:
				serve(connection, prefix / "dosdevices" / f"com{FIRST_NUMBER + len(children)}")
			except OSError:
				pass  # the program has ended
			os._exit(0)
		connection.close()
		children.append(child)
	for child in children:
		os.waitpid(child, 0)
	return program.returncode


if __name__ == "__main__":
	sys.exit(main())
