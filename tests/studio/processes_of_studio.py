"""The studio in a process of its own."""

import re
import subprocess
import sys

from pages import Client


class Process:
    """The command in a process of its own."""

    def __init__(self, folder, *words, browser=False):
        code = "import sys; from weftex.cli import entry; entry()"
        words = ["studio", *words, "--data", str(folder), *([] if browser else ["--no-browser"])]
        self.run = subprocess.Popen(
            [sys.executable, "-c", code, *words], stderr=subprocess.PIPE, text=True
        )
        line = next(line for line in self.run.stderr if "http://" in line)
        port, self.token = re.search(r"http://127\.0\.0\.1:(\d+)/#token=(\S+)", line).groups()
        self.client = Client(int(port))

    def end(self, number):
        self.run.send_signal(number)
        code = self.run.wait(10)
        self.run.stderr.close()
        return code
