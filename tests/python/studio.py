"""`puffer studio` as a browser asks it, and as nobody may: `studio.py`, with the package in PYTHONPATH and programs in its `bin`.

It needs no packages of others: bodies are those of `cad2fem new`, and make finds a Makefile that waits.
"""

import http.client
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

WAITS = "all:\n\t@echo /cad2fem model it -o build/model; sleep 60\n"


class Studio:
    """A studio in a folder, as a terminal starts it."""

    def __init__(self, folder, *options):
        command = [sys.executable, "-B", "-m", "softpuffer", "studio", str(folder), "--no-browser", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        _, _, self.host, self.token, _ = self.address.split("/")
        self.headers = {"Origin": f"http://{self.host}", "X-Puffer": "studio"}

    def ask(self, method, path, body=None, headers=None, token=None):
        """The status of an answer, what it says and its headers; `path` is after the token."""
        connection = http.client.HTTPConnection("127.0.0.1", int(self.host.split(":")[1]), timeout=30)
        connection.request(method, f"/{token or self.token}/{path}", body, headers or {})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        known = answer.headers.get_content_type() == "application/json"
        return answer.status, json.loads(content) if known else content.decode(), answer.headers

    def get(self, path):
        return self.ask("GET", path)

    def post(self, path, body=b"", **headers):
        body = body.encode() if isinstance(body, str) else body
        more = {name.replace("_", "-"): value for name, value in headers.items()}
        return self.ask("POST", path, body, {**self.headers, **more})

    def state(self, body="mine"):
        return self.get(f"bodies/{body}")[1]

    def end(self, how=signal.SIGINT):
        """What it said at its end."""
        self.process.send_signal(how)
        return self.process.communicate(timeout=20)


class Requests(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.studio = self.started()

    def started(self, *options):
        studio = Studio(self.folder, *options)
        self.addCleanup(studio.process.communicate)
        self.addCleanup(studio.process.kill)
        return studio

    def begun(self):
        status, state, _ = self.studio.post("bodies/mine/new")
        self.assertEqual((status, state["models"]), (200, ["model.toml"]), state)
        return self.folder / "mine"

    def refused(self, answer, status, *words):
        self.assertEqual(answer[0], status, answer[1])
        for word in words:
            self.assertIn(word, answer[1]["message"])

    def test_nobody_else_is_answered(self):
        ask, ours = self.studio.ask, self.studio.headers
        status, page, headers = self.studio.get("")
        self.assertEqual((status, "puffer studio" in page), (200, True))
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        self.refused(ask("GET", "", token="wrong"), 403, "address")
        self.refused(ask("GET", "", headers={"Host": "evil.example:80"}), 403, "evil.example")
        self.assertEqual(ask("GET", "", headers={"Host": self.studio.host.replace("127.0.0.1", "localhost")})[0], 200)
        for headers in ({}, {**ours, "Origin": "http://evil.example"}, {**ours, "Origin": "null"}, {"Origin": ours["Origin"]}):
            self.refused(ask("POST", "bodies/mine/new", b"", headers), 403, "page of the studio")
        self.refused(ask("GET", "bodies/mine/make", headers=ours), 405, "posted")
        self.assertEqual(ask("PUT", "bodies/mine/new", b"", ours)[0], 501)
        self.assertEqual(os.listdir(self.folder), [])
        # the token is not for those who list processes, nor the port for other machines
        if sys.platform == "linux":
            told = Path(f"/proc/{self.studio.process.pid}/cmdline").read_bytes()
            self.assertNotIn(self.studio.token.encode(), told)
            port = f"{int(self.studio.host.split(':')[1]):04X}"
            self.assertIn(f" 0100007F:{port} ", Path("/proc/net/tcp").read_text())

    def test_names_lead_nowhere_else(self):
        post, get = self.studio.post, self.studio.get
        for name in ("..", ".", "%2e%2e", "-mine", "mi%20ne", "a%2fb", "%00", "m%C3%BCll", ""):
            self.assertIn(post(f"bodies/{name}/new")[0], (400, 405), name)
        self.assertEqual(os.listdir(self.folder), [])
        mine = self.begun()
        (self.folder / "secret.toml").write_text("secret")
        (mine / "linked.toml").symlink_to("../secret.toml")
        (mine / "out").symlink_to("..")
        for name in ("../secret.toml", "%2e%2e/secret.toml", "linked.toml", "out/secret.toml", "/etc/passwd", "build", ".", "%00"):
            self.refused(get(f"bodies/mine/files/{name}"), 404, "no such file")
            self.assertIn(post(f"bodies/mine/save/{name}", b"puffer = 1", If_Match="0")[0], (404, 405), name)
        (self.folder / "away").symlink_to("mine")
        self.refused(get("bodies/away"), 404, "no such body")
        self.assertEqual((self.folder / "secret.toml").read_text(), "secret")
        self.refused(post("bodies/mine/save/Makefile", b"all:", If_Match="0"), 404, "no file that is edited here")
        self.refused(post("bodies/other/new/sh", b"#!"), 400, "no such CAD file", ".step")
        self.refused(post("bodies/other/new/step"), 400, "empty")
        self.refused(post("bodies/mine/pick", b"--subtract /etc/passwd"), 400, "mark the solids")
        self.refused(post("bodies/other/new/step", b"", Content_Length=str(10**9)), 413, "1000 MB", "200 MB")
        self.refused(post("bodies/mine/new"), 422, "is there already")
        self.refused(post("bodies/mine/model/step", b"ISO"), 409, "mine/model.toml is this body's model")
        self.assertEqual(sorted(os.listdir(self.folder)), ["away", "mine", "secret.toml"])

    def test_a_port_that_is_taken(self):
        port = self.studio.host.split(":")[1]
        command = [sys.executable, "-B", "-m", "softpuffer", "studio", str(self.folder), "--no-browser", "--port", port]
        second = subprocess.run(command, capture_output=True, text=True, timeout=20)
        self.assertEqual(second.returncode, 2)
        self.assertRegex(second.stderr, rf"^puffer studio: port {port}: .*in use; give another --port")
        self.assertNotEqual(self.started().host, self.studio.host)

    def test_two_browsers_save_and_programs_check(self):
        mine = self.begun()
        before = (mine / "sim.toml").read_text()
        _, text, headers = self.studio.get("bodies/mine/files/sim.toml")
        self.assertEqual(text, before)
        seen = headers["ETag"]
        wrong = before.replace("pressure = 8e3", "presure = 8e3")
        self.refused(self.studio.post("bodies/mine/save/sim.toml", wrong, If_Match=seen), 422, "mine/sim.toml:18:1", "did you mean `pressure`?")
        self.assertEqual((mine / "sim.toml").read_text(), before)
        changed = self.studio.post("bodies/mine/set/sim.toml", json.dumps({"number": 2, "key": "pressure", "value": 5e3}), If_Match=seen)
        self.assertEqual((changed[0], changed[1]["chambers"]), (200, [{"number": 2, "on": "cavity", "pressure": 5e3}]))
        after = (mine / "sim.toml").read_text()
        self.assertEqual(after, before.replace("8e3 ", "5000.0 "))
        # who has seen what was there before does not save over it
        self.refused(self.studio.post("bodies/mine/save/sim.toml", before, If_Match=seen), 412, "changed meanwhile")
        self.assertEqual((mine / "sim.toml").read_text(), after)
        # each file, and by the program that reads it
        for file, key, other in (("tags.toml", "name", "nam"), ("mold.toml", "chamber", "chambr"), ("cad2fem.toml", "mesher", "meshr"),
                                 ("model.toml", "grid", "grod"), ("sim.blocked.toml", "include", "inclde")):
            text, version = (mine / file).read_text(), self.studio.state()["files"][file]
            refused = self.studio.post(f"bodies/mine/save/{file}", text.replace(f"\n{key} =", f"\n{other} ="), If_Match=version)
            self.refused(refused, 422, f"mine/{file}", other)
            self.assertEqual(self.studio.post(f"bodies/mine/save/{file}", f"# mine\n{text}", If_Match=version)[0], 200, file)
            self.assertEqual((mine / file).read_text(), f"# mine\n{text}")
        self.assertEqual([name for name in os.listdir(mine) if name.startswith(".")], [])

    def test_what_a_scene_lacks_is_said_and_mended(self):
        mine = self.begun()
        tags = (mine / "tags.toml").read_text().replace('name = "tip"', 'name = "end"').replace('name = "cavity"', 'name = "air"')
        self.assertEqual(self.studio.post("bodies/mine/save/tags.toml", tags, If_Match=self.studio.state()["files"]["tags.toml"])[0], 200)
        state = self.studio.state()
        missing = [(one["file"], one["key"], one["name"]) for one in state["missing"]]
        self.assertEqual(missing, [("sim.toml", "on", "cavity"), ("sim.toml", "on", "tip"), ("mold.toml", "chamber", "cavity")])
        self.assertEqual(state["unfilled"], ["air"])
        chamber, probe, mold = state["missing"]
        for one, change in ((probe, {"leave": probe["number"]}), (mold, {"number": 0, "key": "chamber", "value": "air"}),
                            (chamber, {"number": chamber["number"], "key": "on", "value": "air"})):
            version = self.studio.state()["files"][one["file"]]
            self.assertEqual(self.studio.post(f"bodies/mine/set/{one['file']}", json.dumps(change), If_Match=version)[0], 200)
        state = self.studio.state()
        self.assertEqual((state["missing"], state["unfilled"]), ([], []))
        self.assertIn('# [[probe]]\n# name = "bending"', (mine / "sim.toml").read_text())

    def test_a_run_outlives_the_studio_and_is_not_started_twice(self):
        mine = self.begun()
        (mine / "Makefile").write_text(WAITS)
        self.assertTrue(self.studio.post("bodies/mine/make")[1]["run"]["running"])
        self.refused(self.studio.post("bodies/mine/make"), 409, "is being made")
        self.refused(self.studio.post("bodies/mine/save/sim.toml", b"", If_Match=self.studio.state()["files"]["sim.toml"]), 409, "is being made")
        self.studio.end(signal.SIGKILL)
        self.studio = self.started()
        self.assertEqual(self.studio.get("bodies")[1]["bodies"], [{"name": "mine", "running": True}])
        ends = time.monotonic() + 20
        while not (run := self.studio.state()["run"])["done"] and time.monotonic() < ends:
            time.sleep(0.05)
        self.assertEqual((run["running"], run["command"], run["step"]), (True, "puffer make -C mine", "cad2fem model"))
        self.refused(self.studio.post("bodies/mine/make"), 409, "is being made")
        said, wrong = self.studio.end()
        self.assertIn("mine is still being made, see mine/build/studio.log", said)
        self.assertEqual((wrong, self.studio.process.returncode), ("", 0))
        self.studio = self.started()
        run = self.studio.post("bodies/mine/stop")[1]["run"]
        self.assertEqual((run["running"], run["code"]), (False, None))
        self.refused(self.studio.post("bodies/mine/stop"), 409, "nothing runs")
        # what ended well and what failed are told apart
        for makefile, code in (("all:\n\t@echo good", 0), ("all:\n\t@echo 'fab: not this' >&2; exit 1", 2)):
            (mine / "Makefile").write_text(makefile)
            self.studio.post("bodies/mine/make")
            while (run := self.studio.state()["run"])["running"]:
                time.sleep(0.05)
            self.assertEqual(run["code"], code, run)


if __name__ == "__main__":
    # a shell that starts tests in the background has them ignore it, and the studio with them
    signal.signal(signal.SIGINT, signal.default_int_handler)
    unittest.main()
