"""vdblic_view's page draws lines by itself while something moves."""

import base64
import re
import subprocess
import unittest

import numpy

from support import BIN
from viewer_page import BrowserTest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

# Remembers the drawings' contexts, and what is asked for. No picture takes time, so none is coarse.
SPY = """
    performance.now = () => 0;
    window.contexts = [];
    const contextOf = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        const context = contextOf.call(this, kind, ...more);
        if (kind === "webgl2" && context && !contexts.includes(context)) contexts.push(context);
        return context;
    };
    window.asked = [];
    const send = fetch;
    window.fetch = (path, options) => {
        if (path !== "status") asked.push([path, JSON.parse(options?.body || "{}")]);
        return send(path, options);
    };
"""
# Drags the picture, and looks at it while the hand moves.
DRAG = """
    const [x, y, done] = arguments, canvas = document.getElementById("picture");
    canvas.setPointerCapture = () => {};
    const send = (type, x, y) => canvas.dispatchEvent(
        new PointerEvent(type, {pointerId: 1, clientX: 200 + x, clientY: 200 + y, button: 0, bubbles: true}));
    send("pointerdown", 0, 0);
    send("pointermove", x, y);
    const look = () => {
        const { textContent } = document.getElementById("progress");
        if (!textContent.includes("pictures/s")) return setTimeout(look, 5);
        done([canvas.toDataURL(), textContent]);
        send("pointerup", x, y);
    };
    look();
"""


class Lines(BrowserTest):
    """A test case with lines `s.%04d.vdb`, frames 1 to 3."""

    isLoud = False  # whether the browser may complain of a request that was refused

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": SPY})
        run = lambda *command: subprocess.run(list(map(str, command)), cwd=cls.data, check=True, capture_output=True)
        run(BIN / "vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", "--method", "streaks", "--draw", "lines", "--spacing", 4,
            "--tail", 3, "--with", "q")

    def setUp(self):
        super().setUp()
        for path in self.data.glob("s.*.vdb"):
            (self.folder / path.name).write_bytes(path.read_bytes())

    def complaints(self):
        """Those of a picture that is read from SwiftShader, which takes time, are no news."""
        return [entry for entry in super().complaints() if "GPU stall" not in entry["message"]
                and not (self.isLoud and "422" in entry["message"])]

    def open(self, *arguments):
        super().open(*map(str, arguments), source="s.%04d.vdb")
        self.wait_until(lambda: self.asked("lines"), "no lines")
        self.wait_until_at_rest()

    def asked(self, path):
        """What was asked for."""
        return self.browser.execute_script("return asked.filter(([path]) => path === arguments[0]).map((all) => all[1])", path)

    def moving(self):
        """Pictures of something that moves that the program was asked for."""
        return [body for body in self.asked("picture") if body["quality"] < 80]

    def drag(self, x, y):
        """@return the picture while the hand moves and the settled one, and what was told of the first"""
        address, told = self.browser.execute_async_script(DRAG, x, y)
        self.wait_for_refined()
        return self.image(address), self.image(self.pixels()), told

    def image(self, address):
        """The pixels of a picture: rows, columns, channels."""
        (self.folder / "shot.png").write_bytes(base64.b64decode(address.split(",")[1]))
        raw = subprocess.run(["ffmpeg", "-v", "error", "-i", self.folder / "shot.png", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                             capture_output=True, check=True).stdout
        width, height = self.browser.execute_script("const p = document.getElementById('picture'); return [p.width, p.height]")
        return numpy.frombuffer(raw, numpy.uint8).reshape(height, width, 3).astype(int)

    def lit(self, image, least=40):
        """Which pixels are not of the ground."""
        return abs(image - image[:, 2:3]).max(axis=2) > least

    def assert_same_places(self, drawn, settled):
        """The lines of two pictures lie on each other: no shift makes them more alike, by more than a pixel."""
        a, b = self.lit(drawn), self.lit(settled)
        self.assertGreater(a.sum(), 2000)
        self.assertGreater(b.sum(), 2000)
        shifts = [(x, y) for x in range(-5, 6) for y in range(-5, 6)]
        alike = {shift: (numpy.roll(a, shift, (1, 0)) == b).mean() for shift in shifts}
        best = max(alike, key=alike.get)
        self.assertLessEqual(max(map(abs, best)), 1, best)
        faint = self.lit(settled, 12)
        near = sum(numpy.roll(faint, shift, (1, 0)) for shift in shifts if max(map(abs, shift)) <= 2) > 0
        self.assertGreater((a & near).sum(), 0.95 * a.sum())


class Drawing(Lines):
    flags = ("--enable-unsafe-swiftshader",)

    def test_settled_pictures_lie_on_drawn_ones(self):
        for arguments in (), ("--projection", "orthographic"), ("--stretch", 1, 1, 2, "--opacity-by", "q"), \
                ("--clip-plane", 0.9, 0.4, 0.3, 1, 0.3, 0.2, "--look", "paper"):
            with self.subTest(arguments=arguments):
                self.open("--samples", 2, *arguments)
                drawn, settled, told = self.drag(60, 25)
                self.assertRegex(told, r"pictures/s$")  # all lines
                self.assert_same_places(drawn, settled)
                self.assertEqual(self.moving(), [])
                self.assertEqual(self.browser.execute_script("return contexts.length"), 1)
                self.stop()

    def test_colours_and_ranges_follow_here(self):
        self.open("--samples", 2)
        before = self.image(self.pixels())
        change = lambda selector, value: self.browser.execute_script("""
            const field = document.querySelector(arguments[0]);
            field.value = arguments[1];
            field.dispatchEvent(new Event("change"));""", selector, value)
        change("input[aria-label='Colour: upper end of the range']", "5")
        self.wait_until(lambda: "range" in self.options(), "no range")
        self.wait_for_refined()
        self.choose("colormap", "viridis")
        self.wait_until(lambda: "colormap" in self.options(), "no map")
        self.wait_for_refined()
        drawn, settled, _ = self.drag(6, 0)
        self.assertEqual(self.moving(), [])
        colour = lambda image: image[self.lit(image)].mean(axis=0)
        self.assertLess(numpy.argmax(colour(drawn)), 2)  # viridis above its range is green and yellow
        for channel in range(3):
            drawn_share, settled_share = (colour(image)[channel] / colour(image).sum() for image in (drawn, settled))
            self.assertAlmostEqual(drawn_share, settled_share, delta=0.08)
        self.assertGreater(abs(colour(settled) - colour(before)).max(), 20)
        # What the page cannot draw is asked for.
        self.browser.execute_script("document.getElementById('light-on').closest('details').open = true")
        self.element("light-on").click()
        self.wait_until(self.moving, "light is not the program's")
        self.wait_for_refined()

    def choose(self, name, value):
        self.browser.execute_script("document.getElementById(arguments[0]).click()", f"{name}-{value}")

    def test_playing(self):
        self.open("--samples", 1)
        self.browser.execute_script("delete performance.now")  # the clock goes again
        shown = lambda: self.element("picture").get_attribute("data-frame")
        seen = set()

        def has_seen_all():
            seen.add(shown())
            return seen == {"1", "2", "3"}

        def play():
            seen.clear()
            self.element("play").click()
            self.wait_until(has_seen_all, "does not play")
            self.element("play").click()
            self.wait_for_refined()

        play()
        self.assertEqual({body["frame"] for body in self.asked("lines")}, {1, 2, 3})
        self.browser.execute_script("asked.length = 0")
        play()
        self.assertEqual(self.asked("lines"), [])  # they are kept
        self.assertEqual(self.moving(), [])

    def test_key_frames_are_the_programs(self):
        self.open("--samples", 1, "--orbit", 40, "--orbit-frames", 3)
        ActionChains(self.browser).send_keys(".").perform()
        self.wait_until(self.moving, "drawn here")
        self.wait_for_refined()

    def change_context(self, act):
        """Lose or restore the drawings' context, and wait until it is so."""
        self.browser.execute_async_script("""
            const [act, done] = arguments;
            contexts[0].canvas.addEventListener(act === "lose" ? "webglcontextlost" : "webglcontextrestored", () => done(), { once: true });
            window.ends ??= contexts[0].getExtension("WEBGL_lose_context");
            ends[`${act}Context`]();""", act)

    def test_a_lost_context(self):
        self.open("--samples", 1)
        self.change_context("lose")
        self.drag(30, 0)
        asked = len(self.moving())
        self.assertGreater(asked, 0)
        self.change_context("restore")
        drawn, settled, _ = self.drag(30, 0)
        self.assert_same_places(drawn, settled)
        self.assertEqual(len(self.moving()), asked)

    def test_a_damaged_frame(self):
        """It is told of; the others are drawn."""
        whole = (self.folder / "s.0002.vdb").read_bytes()
        (self.folder / "s.0002.vdb").write_bytes(whole[: len(whole) // 2])
        self.isLoud = True
        self.open("--samples", 1)
        press = lambda *keys: ActionChains(self.browser).send_keys(*keys).perform()
        press(".")
        self.wait_until(lambda: "s.0002.vdb" in self.element("message").text, "not told")
        press(".")
        self.wait_until(lambda: self.element("message").text == "", "told still")
        self.wait_for_refined()
        drawn, settled, _ = self.drag(30, 0)
        self.assert_same_places(drawn, settled)


class WithoutWebGL(Lines):
    flags = ("--disable-3d-apis",)

    def test_the_program_makes_the_pictures(self):
        BrowserTest.open(self, "--samples", "1", source="s.%04d.vdb")
        self.drag(30, 0)
        self.assertGreater(len(self.moving()), 0)
        self.assertEqual(self.asked("lines"), [])


if __name__ == "__main__":
    unittest.main()
