"""vdblic_export into a page: what a browser shows of it, and what it refuses."""

import base64
import gzip
import html
import json
import re
import shutil
import subprocess
import time
import unittest

import numpy

import python_module  # pylint: disable=unused-import
import vdblic
from support import BIN, ToolTest, skip

try:
    from selenium import webdriver
except ImportError:
    skip("python3-selenium is not installed")
if not shutil.which("chromium") or not shutil.which("chromedriver"):
    skip("chromium is not installed")

from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from vdblic._core import read_lines
from vdblic.surfaces import thinned

FRAMES = range(1, 5)


def browser(*more):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=900,700",
                     "--force-prefers-reduced-motion", *more):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def packed(page):
    """What a page holds: what it tells of the flow, and its columns of whole numbers, in the order of data.js."""
    text = page.read_text(encoding="utf-8")
    flow = json.loads(re.search(r'<script type="application/json" id="flow">(.*?)</script>', text)[1])
    data = gzip.decompress(base64.b64decode(re.search(r'id="data">(.*?)</script>', text)[1]))
    columns, at = [], 0
    for count in [flow["points"]] * 4 + [flow["lines"]] * 4:
        low, high = (numpy.frombuffer(data, numpy.uint8, count, at + i * count).astype(int) for i in range(2))
        folded = low | high << 8
        columns.append(numpy.cumsum((folded >> 1) ^ -(folded & 1)) & 0xFFFF)
        at += 2 * count
    return flow, columns


def nearby(pixels):
    """Those pixels and their neighbours."""
    wide = pixels | numpy.roll(pixels, 1, 0) | numpy.roll(pixels, -1, 0)
    return wide | numpy.roll(wide, 1, 1) | numpy.roll(wide, -1, 1)


class Pages(ToolTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-5")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", "--method", "streaks", "--draw", "lines",
                     "--spacing", 3, "--tail", 3, "--with", "q", "--frames", "1-4")

    def export(self, *arguments, output="flow.html", source="s.%04d.vdb"):
        (path,) = self.outputs("vdblic_export", source, "-o", output, *arguments)
        return self.folder / path

    def open(self, path, state=None):
        self.browser.get("about:blank")
        self.browser.get_log("browser")
        self.browser.get_log("performance")
        self.browser.get(path.as_uri() + (f"#{json.dumps(state)}" if state else ""))
        self.wait_until(lambda: self.element("message").text != "Loading…", "not loaded")

    def element(self, name):
        return self.browser.find_element(By.ID, name)

    def wait_until(self, condition, what, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.05)

    def requests(self):
        events = (json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance"))
        urls = {event["params"]["request"]["url"].split("#")[0] for event in events
                if event["method"] == "Network.requestWillBeSent"}
        return {url for url in urls if not url.startswith("data:image/png;base64,")}  # the still, in the page itself

    def lit(self):
        """Which pixels of the picture differ from its ground; nothing lies over it."""
        self.browser.execute_script("""
            for (const other of document.querySelectorAll("h1, #legend, #scale, #time, #panel, #caption, #message"))
                other.style.visibility = "hidden";
            return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))""")
        (self.folder / "shot.png").write_bytes(self.element("picture").screenshot_as_png)
        return self.pixels("shot.png")

    def pixels(self, name):
        size = self.browser.execute_script("const p = document.getElementById('picture'); return [p.clientHeight, p.clientWidth]")
        raw = self.raw_of(name)
        image = raw.reshape(*size, 3).astype(int)
        return abs(image - image[2, 2]).max(axis=2) > 24

    def raw_of(self, name):
        return numpy.frombuffer(subprocess.run(
            ["ffmpeg", "-v", "error", "-i", self.folder / name, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
            capture_output=True, check=True).stdout, numpy.uint8)

    def test_opens_alone(self):
        """From a file and in a frame without rights: no request, no error, a picture."""
        page = self.export()
        self.open(page)
        self.assertEqual(self.element("message").text, "")
        self.assertTrue(self.lit().any())
        self.assertEqual(self.requests(), {page.as_uri()})
        self.assertEqual(self.browser.get_log("browser"), [])
        (self.folder / "frame.html").write_text(
            '<iframe id="inner" sandbox="allow-scripts" src="flow.html" width="600" height="400"></iframe>')
        self.browser.get((self.folder / "frame.html").as_uri())
        self.browser.switch_to.frame("inner")
        self.wait_until(lambda: self.element("message").text == "", "no picture in a frame")
        self.assertEqual(self.browser.get_log("browser"), [])
        self.assertEqual(self.requests(), {(self.folder / name).as_uri() for name in ("frame.html", "flow.html")})

    def test_in_a_notebook(self):
        """streaks() of Python makes the same page, and a frame without rights shows it."""
        made = vdblic.streaks(str(self.folder / "v.%04d.vdb"), frames=range(1, 5), spacing=3, tail=3, with_="q")
        made.save(self.folder / "notebook.html")
        self.assertEqual(list(made), [])
        columns = lambda name: numpy.concatenate(packed(self.folder / name)[1])
        self.export()
        numpy.testing.assert_array_equal(columns("notebook.html"), columns("flow.html"))
        shown = made._repr_html_()
        self.assertEqual(html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1]), (self.folder / "notebook.html").read_text())
        (self.folder / "cell.html").write_text(f"<!doctype html><title>cell</title>{shown}")
        self.browser.get("about:blank")
        self.browser.get_log("browser")
        self.browser.get((self.folder / "cell.html").as_uri())
        self.browser.switch_to.frame(0)
        self.wait_until(lambda: self.element("message").text == "", "no picture in a notebook")
        self.assertEqual(self.browser.get_log("browser"), [])

    def test_runs_without_a_page(self):
        source = str(self.folder / "v.0001.vdb")
        voxels = vdblic.streaks(source, spacing=6, draw="voxels")
        self.assertIsNone(voxels._repr_html_())
        with self.assertRaisesRegex(ValueError, "leave `draw` out"):
            voxels.save(self.folder / "a.html")
        self.assertEqual(len(list(voxels)), 1)
        ended = vdblic.streaks(source, spacing=6)
        next(ended)
        ended.close()
        self.assertIsNone(ended._repr_html_())
        with self.assertRaisesRegex(ValueError, "the run has ended"):
            ended.save(self.folder / "a.html")
        with self.assertRaisesRegex(ValueError, r"a\.png"):
            ended.save(self.folder / "a.png")
        self.assertFalse((self.folder / "a.html").exists())

    def test_places_are_exact(self):
        """What each frame adds to the paths is there, within 1/4000 of the box, at its time."""
        flow, (x, y, z, moment, counts, *_) = packed(self.export())
        low, high = numpy.array(flow["low"]), numpy.array(flow["high"])
        places = low + numpy.stack([x, y, z], axis=1) / 8191 * (high - low)
        times = flow["begin"] + moment * flow["tick"]
        self.assertEqual(counts.sum(), flow["points"])
        for frame in FRAMES:
            lines, _ = read_lines(str(self.folder / f"s.{frame:04}.vdb"))
            new = lines["age"] < (0.95 if frame > 1 else 3)
            self.assertGreater(new.sum(), 1000)
            for point, age in list(zip(lines["points"][new], lines["age"][new]))[::37]:
                near = abs(times - (frame - age)) < 0.03
                self.assertLess(abs(places[near] - point).max(axis=1).min(), (high - low).max() / 4000, (frame, point))

    def test_pictures_are_the_renderers(self):
        """At three times, from two sides, and of a flow that is shown higher than it is."""
        page = self.export()
        for eye in [4.0, -3.0, 4.0], [-0.5, -2.0, 5.5]:
            for frame in 1, 2, 4:
                self.renders(page, f"s.{frame:04}.vdb", frame, eye, [1.15, 1.15, 1.15])
        self.outputs("vdblic_synth", "tornado", "-o", "f.%04d.vdb", "--size", 48, 48, 4, "--frames", "1-2")
        self.outputs("vdblic_advect", "f.%04d.vdb", "-o", "flat.%04d.vdb", "--method", "streaks", "--draw", "lines", "--spacing", 2,
                     "--tail", 3)
        self.renders(self.export(source="flat.%04d.vdb", output="flat.html"), "flat.0002.vdb", 2, [2.3, -2.0, 5.0], [2.3, 2.0, 0.3])

    def renders(self, page, lines, frame, eye, target):
        """That lines are at the pixels where vdblic_render has them, give or take one, in each part in the same colours."""
        flow, _ = packed(page)
        low, _, high = flow["scalars"][0]["shown"]
        self.open(page, {"camera": {"eye": eye, "target": target, "up": [0, 0, 1], "fov": 35}, "frame": frame, "least": 0, "part": 1,
                         "box": False})
        in_page = self.lit()
        shown = self.raw_of("shot.png").reshape(*in_page.shape, 3).astype(int)
        self.outputs("vdblic_render", lines, "-o", "image.png", "--size", *in_page.shape[::-1], "--eye", *eye, "--target", *target,
                     "--fov", 35, "--range", low, high, "--opacity", "0:0.95,1:0.95", "--by", "magnitude", "--stretch", *flow["stretch"])
        rendered = self.raw_of("image.png").reshape(shown.shape).astype(int)
        in_render = self.pixels("image.png")
        self.assertGreater(in_render.sum(), 20000)
        self.assertLess((in_page & ~nearby(in_render)).sum(), 0.004 * in_page.sum(), (eye, frame))
        self.assertLess((in_render & ~nearby(in_page)).sum(), 0.025 * in_render.sum(), (eye, frame))  # faint tails
        self.assertGreater(in_page.sum(), 0.9 * in_render.sum(), (eye, frame))
        both, differences = in_page & in_render, []
        for y in range(0, both.shape[0] - 100, 100):
            for x in range(0, both.shape[1] - 100, 100):
                part = numpy.s_[y:y + 100, x:x + 100]
                if both[part].sum() > 1000:
                    differences.append((shown - rendered)[part][both[part]].mean(axis=0))
        self.assertGreater(len(differences), 15)
        self.assertLess(numpy.abs(differences).max(), 26, (eye, frame))
        self.assertLess(abs(numpy.mean(differences, axis=0)).max(), 9, (eye, frame))

    def test_picking_a_line(self):
        """A click on the line in front tells its scalars at its time, and Enter those of the line in the middle."""
        page = self.export()
        lines, _ = read_lines(str(self.folder / "s.0003.vdb"))
        heads = numpy.flatnonzero((lines["age"] < 0.01) & (lines["opacity"] > 0.9))
        head = heads[numpy.argmin(lines["points"][heads, 1])]
        target = lines["points"][head]
        eye = target - [0, 4, 0]
        camera = {"eye": eye.tolist(), "target": target.tolist(), "up": [0, 0, 1], "fov": 35}
        self.open(page, {"camera": camera, "frame": 3, "least": 0, "part": 1})
        before = self.lit()
        told = lambda: self.element("picked").text
        self.assertEqual(told(), "")
        ActionChains(self.browser).move_to_element(self.element("picture")).click().perform()
        self.wait_until(told, "nothing told")
        speed, q, time_ = re.fullmatch(r"speed (\S+), q (\S+) 1/s², (\S+) s", told()).groups()
        for value, scale in zip((speed, q), packed(page)[0]["scalars"]):
            true = lines["scalars"][scale["name"]][head]
            step = numpy.hypot(true, scale["bend"]) * (scale["high"] - scale["low"]) / 254
            self.assertAlmostEqual(float(value), true, delta=0.6 * step, msg=scale["name"])
        self.assertAlmostEqual(float(time_), 2 / 24, delta=0.2 / 24)
        self.assertTrue((self.lit() != before).any())
        text = told()
        keys = lambda key: ActionChains(self.browser).send_keys(key).perform()
        keys(Keys.ESCAPE)
        self.assertEqual(told(), "")
        keys(Keys.ENTER)
        self.assertEqual(told(), text)
        ActionChains(self.browser).drag_and_drop_by_offset(self.element("picture"), 60, 10).perform()
        self.assertEqual(told(), text)

    def test_markup_in_names(self):
        title = "<img src=x onerror=alert(1)>&amp;"
        for frame in FRAMES:
            (self.folder / f"s.{frame:04}.vdb").rename(self.folder / f"{title}.{frame:04}.vdb")
        page = self.export(source=f"{title}.%04d.vdb", output=f"{title}.html")
        self.open(page)
        self.assertEqual(self.browser.title, title)
        self.assertEqual(self.requests(), {page.as_uri()})
        self.assertEqual(self.browser.get_log("browser"), [])
        self.assertIn("default-src 'none'", page.read_text(encoding="utf-8"))

    def test_size_and_refusals(self):
        done = self.run_tool("vdblic_export", "s.%04d.vdb", "-o", "flow.html")
        whole = (self.folder / "flow.html").stat().st_size
        self.assertNotIn("the page shows", done.stderr)
        done = self.run_tool("vdblic_export", "s.%04d.vdb", "-o", "few.html", "--max-size", whole // 2)
        shown, total = map(int, re.search(r"shows (\d+) of (\d+) lines, the most important ones by q", done.stderr).groups())
        self.assertLess(shown, total)
        self.assertLessEqual((self.folder / "few.html").stat().st_size, whole // 2)
        self.assertEqual(packed(self.folder / "few.html")[0]["lines"], shown)
        for words, says in (("-o", "a.html", "--max-size", "1k"), "holds no line"), (("-o", "a.html", "--max-size", "x"), "no size"), \
                (("-o", "a.usda", "--max-size", "1M"), "--max-size is of a page"), (("-o", "a.%04d.html"), "one page shows all"), \
                (("-o", "a.html", "--grids", "q"), "leave --grids"), (("-o", "a.html", "--levels", 1), "leave --grids"), \
                (("-o", "a.html", "--up", "y"), "--up is of a layer"):
            self.assertIn(says, self.fails(2, "vdblic_export", "s.%04d.vdb", *words))
        self.assertIn("v.0001.vdb", self.fails(3, "vdblic_export", "v.%04d.vdb", "-o", "a.html"))
        self.assertFalse((self.folder / "a.html").exists())

    def test_without_a_mouse_and_on_a_telephone(self):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": 360, "height": 640, "deviceScaleFactor": 2, "mobile": True})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.open(self.export())
        self.assertLessEqual(self.browser.execute_script("return document.documentElement.scrollWidth"), 360)
        keys = lambda *text: ActionChains(self.browser).send_keys(*text).perform()
        moment = lambda: float(self.element("moment").get_property("value"))
        self.browser.execute_script("document.getElementById('picture').focus()")
        keys(".", ".", ",")
        self.wait_until(lambda: moment() == 2, "no step")
        keys(" ")
        self.wait_until(lambda: moment() > 2.3, "does not play")
        keys(" ")
        self.assertEqual(self.element("play").get_attribute("aria-label"), "Play")
        camera = lambda: json.loads(self.browser.execute_script("return decodeURIComponent(location.hash.slice(1))"))["camera"]
        keys(Keys.ARROW_LEFT)
        self.wait_until(lambda: "camera" in self.browser.execute_script("return decodeURIComponent(location.hash)"), "no address")
        before = camera()
        keys("+")
        self.wait_until(lambda: camera() != before, "no zoom")
        unnamed = self.browser.execute_script("""
            document.getElementById("panel").open = true;
            return [...document.querySelectorAll("button, input, select, summary, [tabindex]")].filter((e) => !(
                e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.length)).map((e) => e.outerHTML)""")
        self.assertEqual(unnamed, [])

    def test_a_lost_context(self):
        self.open(self.export(), {"part": 1})
        before = self.lit()
        self.browser.execute_script("""
            const lost = document.getElementById("picture").getContext("webgl2").getExtension("WEBGL_lose_context");
            lost.loseContext();
            return new Promise((done) => setTimeout(() => { lost.restoreContext(); setTimeout(done, 500); }, 200))""")
        self.wait_until(lambda: (self.lit() == before).all(), "not drawn again")

    def shows_a_still(self, plain):
        """That a browser which draws nothing shows the still with its caption, and no controls."""
        still = plain.find_element(By.ID, "still")
        self.assertTrue(still.is_displayed())
        self.assertGreaterEqual(plain.execute_script("return document.getElementById('still').naturalWidth"), 320)
        self.assertRegex(plain.find_element(By.ID, "caption").text, r"^\d+ lines that follow the flow, from frame 1 to 4: .* box")
        for name in "picture", "panel", "time", "legend", "scale":
            self.assertFalse(plain.find_element(By.ID, name).is_displayed(), name)
        (self.folder / "still.png").write_bytes(still.screenshot_as_png)
        picture = self.raw_of("still.png").reshape(-1, 3).astype(int)
        self.assertGreater((abs(picture - picture[0]).max(axis=1) > 24).mean(), 0.02)
        self.assertEqual([entry for entry in plain.get_log("browser") if entry["level"] == "SEVERE"], [])

    def test_without_webgl(self):
        page = self.export()
        address = re.search(r'<img id="still" src="(data:image/png;base64,[^"]*)"', page.read_text(encoding="utf-8"))[1]
        self.assertLess(len(address), 150_000)
        plain = browser("--disable-gpu", "--disable-3d-apis")
        self.addCleanup(plain.quit)
        plain.get(page.as_uri())
        self.wait_until(lambda: "no WebGL 2" in plain.find_element(By.ID, "message").text, "not told")
        self.shows_a_still(plain)
        plain.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
        plain.get(page.as_uri())
        self.assertIn("switched off", plain.find_element(By.TAG_NAME, "noscript").get_property("textContent"))
        self.assertFalse(plain.find_element(By.ID, "message").is_displayed())
        self.shows_a_still(plain)

    def test_a_shader_that_the_browser_refuses(self):
        page = self.export()
        plain = browser("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
        self.addCleanup(plain.quit)
        plain.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": """
            const { shaderSource } = WebGL2RenderingContext.prototype;
            WebGL2RenderingContext.prototype.shaderSource = function (shader, text) {
                shaderSource.call(this, shader, text.replace("isShort", "is short"));
            };"""})
        plain.get(page.as_uri())
        self.wait_until(lambda: "cannot draw" in plain.find_element(By.ID, "message").text, "not told")
        self.shows_a_still(plain)

    def test_a_middle_frame_without_q(self):
        """The still is of the middle frame, which may have fewer scalars than others."""
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "plain.%04d.vdb", "--method", "streaks", "--draw", "lines")
        shutil.copy(self.folder / "plain.0003.vdb", self.folder / "s.0003.vdb")
        self.assertTrue(self.export().is_file())

    def test_colours_on_a_bright_ground(self):
        """The page chooses a map that a bright ground does not swallow, and keeps the user's."""
        page = self.export()
        seen, maps = {}, {}
        for dark in True, False:
            self.open(page, {"dark": dark, "part": 1, "frame": 3, "box": False})
            maps[dark] = self.element("map").get_property("value")
            seen[dark] = self.lit().sum()
        self.assertNotEqual(*maps.values())
        self.assertGreater(seen[False], 0.8 * seen[True])
        self.open(page, {"dark": False, "map": maps[True], "part": 1, "frame": 3, "box": False})
        self.assertEqual(self.element("map").get_property("value"), maps[True])

    def test_a_solid(self):
        """It lies where vdblic_render has it, and hides what is behind."""
        corners = [(x, y, z) for x in (0.6, 1.4) for y in (0.8, 1.5) for z in (0.3, 2)]
        faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        (self.folder / "block.obj").write_text("".join(
            f"{kind} {' '.join(map(str, numbers))}\n" for kind, rows in (("v", corners), ("f", numpy.add(faces, 1)))
            for numbers in rows))
        page = self.export("--solid", "block.obj")
        eye, target = [4.0, -3.0, 4.0], [1.15, 1.15, 1.15]
        state = {"camera": {"eye": eye, "target": target, "up": [0, 0, 1], "fov": 35}, "frame": 4, "part": 1, "box": False}
        self.open(page, state | {"least": 1})
        solid = self.lit()
        self.assertEqual(self.browser.get_log("browser"), [])
        self.outputs("vdblic_render", "s.0004.vdb", "-o", "image.png", "--size", solid.shape[1], solid.shape[0], "--eye", *eye,
                     "--target", *target, "--fov", 35, "--opacity", "0:0,1:0", "--solid", "block.obj", "--solid-color", 1, 1, 1)
        rendered = self.pixels("image.png")
        self.assertGreater(solid.sum(), 1000)
        self.assertLess((solid ^ rendered).sum(), 0.04 * rendered.sum())
        far = {"eye": [1.15, -6.0, 1.15], "target": target, "up": [0, 0, 1], "fov": 35}
        hidden = []
        for name in "flow.html", "without.html":
            page = self.folder / name if name == "flow.html" else self.export(output=name)
            self.open(page, state | {"camera": far, "least": 0, "shownBy": 0, "clip": "y", "cut": 1})
            self.lit()
            hidden.append(self.raw_of("shot.png").reshape(*solid.shape, 3).astype(int))
        colourful = [(image.max(axis=2) - image.min(axis=2) > 40).sum() for image in hidden]
        self.assertLess(colourful[0], 0.95 * colourful[1])

    def test_a_solid_that_changes(self):
        """A page shows one, and says so."""
        for moves in True, False:
            for frame in range(1, 6):
                active = numpy.ones((16, 16, 16), bool)
                active[4 + moves * frame:8 + moves * frame, 6:10, 6:10] = False
                velocity = vdblic.Grid(numpy.full((16, 16, 16, 3), (1, 0.2, 0.1)), active, name="velocity", metadata={"frame": frame, "dt": 1.0})
                vdblic.write(self.folder / f"b.{frame:04}.vdb", velocity)
            self.outputs("vdblic_advect", "b.%04d.vdb", "-o", "c.%04d.vdb", "--method", "streaks", "--draw", "lines", "--frames", "1-4")
            done = self.run_tool("vdblic_export", "c.%04d.vdb", "-o", f"{moves}.html", "--solid", "domain")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("the page shows the solid of frame 1, at all times"), moves)

    def test_the_ground(self):
        """It lies where vdblic_render has it, as bright, and hides nothing from below."""
        page = self.export()
        target = [1.15, 1.15, 1.15]
        for height in 4.0, -2.0:
            eye = [6.0, -6.0, height]
            state = {"camera": {"eye": eye, "target": target, "up": [0, 0, 1], "fov": 35}, "frame": 3, "part": 1, "least": 2, "box": False}
            self.open(page, state | {"ground": True})
            ground = self.lit()
            shown = self.raw_of("shot.png").reshape(*ground.shape, 3).astype(int)
            self.assertEqual(self.browser.get_log("browser"), [])
            self.outputs("vdblic_render", "s.0003.vdb", "-o", "image.png", "--size", *ground.shape[::-1], "--eye", *eye, "--target",
                         *target, "--fov", 35, "--opacity", "0:0,1:0", "--ground", "below")
            rendered = self.pixels("image.png")
            if height < 0:
                self.assertFalse(ground.any() or rendered.any())
                continue
            self.assertGreater(ground.sum(), 20000)
            self.assertLess((ground ^ rendered).sum(), 0.05 * rendered.sum())
            image = self.raw_of("image.png").reshape(shown.shape).astype(int)
            self.assertLess(abs(shown - image)[ground & rendered].mean(), 4)

    def test_a_fine_surface_is_thinned(self):
        """A closed surface keeps its volume, though it is flat."""
        turns, heights = numpy.meshgrid(numpy.linspace(0, 2 * numpy.pi, 600), numpy.linspace(0, numpy.pi, 300))
        ball = numpy.stack([numpy.sin(heights) * numpy.cos(turns), numpy.sin(heights) * numpy.sin(turns), numpy.cos(heights)], axis=-1)
        number = numpy.arange(turns.size).reshape(turns.shape)
        a, b, c, d = (cut.ravel() for cut in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
        triangles = numpy.concatenate([numpy.stack([a, b, c], axis=1), numpy.stack([a, c, d], axis=1)])
        for sides in (1, 1, 1), (100, 100, 0.1):
            points, fewer = thinned(ball.reshape(-1, 3) * sides, triangles)
            self.assertLess(len(points), 65536)
            self.assertLess(len(fewer), 60001)
            self.assertGreater(len(fewer), 10000)
            p, q, r = (points[fewer[:, i]] for i in range(3))
            volume = (p * numpy.cross(q, r)).sum() / 6
            self.assertAlmostEqual(volume / (4 / 3 * numpy.pi * numpy.prod(sides)), 1, delta=0.03)

    def test_refused_solids(self):
        for status, words, says in ((2, ("-o", "a.usda", "--solid", "domain"), "--solid is of a page"),
                                    (3, ("-o", "a.html", "--solid", "none.obj"), "none.obj"),
                                    (3, ("-o", "a.html", "--solid", "domain"), "has no surface")):
            self.assertIn(says, self.fails(status, "vdblic_export", "s.%04d.vdb", *words))
        self.assertFalse((self.folder / "a.html").exists())

    def test_film_of_velocities(self):
        """vdblic_film makes a page in one command, and prints the two that make the same."""
        done = self.run_tool("vdblic_film", "v.%04d.vdb", "-o", "whole.html", "--size", 96, 64)
        self.assertEqual((done.returncode, done.stdout), (0, "whole.html\n"), done.stderr)
        self.assertEqual([name for name in self.files() if "whole" in name], ["whole.html"])
        flow, _ = packed(self.folder / "whole.html")
        self.assertEqual(flow["frames"], [1, 2, 3, 4, 5])
        self.open(self.folder / "whole.html")
        self.assertEqual(self.element("message").text, "")
        self.assertTrue(self.lit().any())
        self.assertEqual(self.browser.get_log("browser"), [])
        page = self.contents("whole.html")
        commands = re.findall(r"^vdblic_film:   (vdblic_.*)", done.stderr, re.MULTILINE)
        self.assertEqual([command.split()[0] for command in commands], ["vdblic_advect", "vdblic_export"])
        for command in commands:
            subprocess.run(["bash", "-c", f'PATH="{BIN}:$PATH" {command}'], cwd=self.folder, check=True, capture_output=True)
        self.assertEqual(self.contents("whole.html"), page)


if __name__ == "__main__":
    unittest.main()
