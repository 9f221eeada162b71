"""A headless Chromium to open pages in, as a user would: offline, with a mouse, in a window of a laptop's size.

The browser is looked for at $CADFIT_CHROMIUM, then as chromium, chromium-browser, google-chrome or chrome on the path.
It is spoken to over a pipe, in Chrome's DevTools protocol.
"""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time

import pytest

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
CHROMIUM = os.environ.get("CADFIT_CHROMIUM") or next(filter(None, map(shutil.which, _NAMES)), None)
needs_browser = pytest.mark.skipif(
    CHROMIUM is None,
    reason=f"no browser: none of {', '.join(_NAMES)} is on the path, nor does CADFIT_CHROMIUM name one",
)

# For the scripts of tests: how many pixels of a canvas have the very colour; when the next frame is drawn.
_TOOLS = """
const find = (selector) => document.querySelector(selector);
const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
const pixels = (canvas, colour) => {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
  const { width, height } = find(canvas);
  const copy = Object.assign(document.createElement("canvas"), { width, height });
  const pen = copy.getContext("2d", { willReadFrequently: true });
  pen.drawImage(find(canvas), 0, 0);
  const all = pen.getImageData(0, 0, width, height).data;
  let count = 0;
  for (let i = 0; i < all.length; i += 4)
    count += all[i] === r && all[i + 1] === g && all[i + 2] === b && all[i + 3] > 250;
  return count;
};
"""


class Browser:
    """One page at a time; `wrong` and `fetched` gather the errors on the console and the addresses asked for."""

    def __init__(self, folder, size=(1440, 900)):
        to_read, self._out = os.pipe()
        self._in, to_write = os.pipe()
        arguments = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        arguments += [
            f"--window-size={size[0]},{size[1]}",
            f"--user-data-dir={folder}",
            "--no-first-run",
            "about:blank",
        ]
        null = subprocess.DEVNULL

        def wire():  # where it looks for its pipe; by way of others, which may be these very numbers
            for end, place in [(fcntl.fcntl(each, fcntl.F_DUPFD, 10), k) for k, each in ((3, to_read), (4, to_write))]:
                os.dup2(end, place)

        self._process = subprocess.Popen(
            arguments, preexec_fn=wire, close_fds=False, stdin=null, stdout=null, stderr=null
        )
        os.close(to_read)
        os.close(to_write)
        self._number, self._rest, self._session, self._loaded = 0, b"", None, False
        self.wrong, self.fetched = [], []
        (page,) = [each for each in self.call("Target.getTargets")["targetInfos"] if each["type"] == "page"]
        self._session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False
        )

    def call(self, method, **params):
        """Return the answer to one command."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        message |= {"sessionId": self._session} if self._session else {}
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while (answer := self._next()).get("id") != self._number:
            self._note(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def open(self, page):
        """Open a file, and wait until it is there."""
        self.wrong.clear()
        self.fetched.clear()
        self._loaded = False
        self.call("Page.navigate", url=page.resolve().as_uri())
        while not self._loaded:
            self._note(self._next())
        self.run("await frame()")

    def run(self, script):
        """Return what a script returns, as the body of an async function on the page."""
        expression = f"(async () => {{ {_TOOLS} {script} }})()"
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def pixels(self, canvas, colour):
        """Return how many pixels of a canvas have the very colour."""
        return self.run(f"await frame(); return pixels({canvas!r}, {colour!r})")

    def click(self, selector):
        """Click the middle of an element."""
        x, y = self.run(
            f"const b = find({selector!r}).getBoundingClientRect(); return [b.x + b.width/2, b.y + b.height/2]"
        )
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def mouse(self, kind, x, y, button="left", **more):
        """Press, release, move or roll the mouse at a place of the window."""
        more |= {"clickCount": 1} if kind in ("mousePressed", "mouseReleased") else {}
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, **more)
        self.run("await frame()")

    def drag(self, start, end):
        """Drag from one place of the window to another."""
        self.mouse("mousePressed", *start)
        self.mouse("mouseMoved", *end, buttons=1)
        self.mouse("mouseReleased", *end)

    def picture(self, path):
        """Write what the window shows."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def close(self):
        """End the browser."""
        self.call("Browser.close")
        self._process.wait(30)
        os.close(self._in)
        os.close(self._out)

    def _next(self):
        until = time.monotonic() + 20.0
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], max(0.0, until - time.monotonic()))
            assert ready, "the browser does not answer"
            self._rest += os.read(self._in, 1 << 20)
        message, self._rest = self._rest.split(b"\0", 1)
        return json.loads(message)

    def _note(self, event):
        method, params = event.get("method"), event.get("params", {})
        self._loaded |= method == "Page.loadEventFired"
        if method == "Runtime.exceptionThrown":
            self.wrong.append(params["exceptionDetails"].get("exception", {}).get("description", str(params)))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.wrong.append(params["entry"]["text"])
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.wrong.append(str(params["args"]))
        elif method == "Network.requestWillBeSent":
            self.fetched.append(params["request"]["url"])
