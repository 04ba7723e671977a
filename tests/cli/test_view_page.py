"""vdblic_view's page in a browser without a screen."""

import shlex
import subprocess
import unittest

from viewer_page import BrowserTest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

FOCUS = "document.querySelectorAll(arguments[0])[arguments[1]]?.focus()"


class Page(BrowserTest):
    def wait_for_small_pictures(self, frame):
        """Wait until those of looks are all of this frame."""
        made = """return [...document.querySelectorAll(".pick img")].every(
            (image) => image.dataset.key?.includes(`"frame":${arguments[0]}}`))"""
        self.wait_until(lambda: self.browser.execute_script(made, frame), f"no small pictures of frame {frame}")

    def drag(self, selector, x, y, index=0):
        """Drag what is at the place of an element, which the page may replace meanwhile."""
        self.wait_until_at_rest()
        place = self.browser.execute_script("""
            const element = document.querySelectorAll(arguments[0])[arguments[1]];
            element.scrollIntoViewIfNeeded();
            const box = element.getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2]""", selector, index)
        hand = ActionChains(self.browser, duration=30)
        hand.w3c_actions.pointer_action.move_to_location(*map(round, place))
        hand.click_and_hold().move_by_offset(x // 2, y // 2).move_by_offset(x - x // 2, y - y // 2).release().perform()

    def press(self, selector, index, *keys):
        """Keys on an element."""
        self.browser.execute_script(FOCUS, selector, index)
        ActionChains(self.browser).send_keys(*keys).perform()

    def choose(self, name, value):
        """Choose among small pictures."""
        self.browser.execute_script("document.getElementById(arguments[0]).click()", f"{name}-{value}")

    def test_find_a_picture_and_keep_it(self):
        self.open()
        first = self.pixels()

        # Drag: the camera is in the state, and the picture differs.
        self.drag("#picture", 80, 30)
        self.wait_for_refined()
        dragged = self.options()
        self.assertEqual(len(dragged["eye"]), 3)
        self.assertNotEqual(self.pixels(), first)

        # Move a point of opacity by hand and by key.
        self.assertGreater(len(self.find(".curve .point")), 3)
        self.drag(".curve .point", 0, -25, index=3)
        self.wait_for_refined()
        moved = self.options()["opacity"]
        self.press(".curve .point", 3, Keys.ARROW_UP)
        self.wait_for_refined()
        self.assertNotEqual(self.options()["opacity"], moved)

        # Undo and redo.
        self.element("undo").click()
        self.wait_for_refined()
        self.assertEqual(self.options()["opacity"], moved)
        self.element("undo").click()
        self.wait_for_refined()
        self.assertEqual(self.options(), dragged)
        self.element("redo").click()
        self.wait_for_refined()
        self.assertEqual(self.options()["opacity"], moved)

        # A reload shows the same.
        shown, state = self.pixels(), self.options()
        self.browser.refresh()
        self.wait_for_refined()
        self.assertEqual(self.options(), state)
        self.wait_until(lambda: self.pixels() == shown, "the reloaded picture differs")

        # What is kept makes the same picture.
        self.element("keep-png").click()
        self.wait_until(lambda: "Saved" in self.element("kept").text, "no picture was kept")
        picture = self.element("kept").text.split()[-1]
        self.element("keep-files").click()
        self.wait_until(lambda: "and" in self.element("kept").text, "no files were kept")
        tool, *words = shlex.split(self.element("command").text)
        words[words.index("-o") + 1] = "again.png"
        self.outputs(tool, *words, "--frames", 1)
        subprocess.run(["idiff", "-fail", "0", picture, "again.png"], cwd=self.folder, check=True, capture_output=True)

    def assert_kept(self):
        """The kept files and the copied command make the picture of the page."""
        self.element("keep-png").click()
        self.wait_until(lambda: "Saved" in self.element("kept").text, "no picture was kept")
        picture = self.element("kept").text.split()[-1]
        commands = []
        for button, says in ("keep-files", "and"), ("copy-command", "The command is"):
            self.element(button).click()
            self.wait_until(lambda: says in self.element("kept").text, "nothing was kept")
            commands.append(self.element("command").text)
        for number, command in enumerate(commands):
            tool, *words = shlex.split(command)
            words[words.index("-o") + 1] = f"again-{number}.png"
            self.outputs(tool, *words, "--frames", 1)
            self.assertEqual(self.contents(f"again-{number}.png"), self.contents(picture), command)

    def assert_undoable(self, name):
        """Undo gives up an option and redo brings it back, as a reload does."""
        before = self.options()
        self.assertIn(name, before)
        self.element("undo").click()
        self.wait_until(lambda: self.options().get(name) != before[name], "not undone")
        self.element("redo").click()
        self.wait_until(lambda: self.options() == before, "not redone")
        self.wait_for_refined()
        shown = self.pixels()
        self.browser.refresh()
        self.wait_for_refined()
        self.assertEqual(self.options(), before)
        self.wait_until(lambda: self.pixels() == shown, "the reloaded picture differs")

    def test_colour_points(self):
        self.open("--colormap", "gray")
        self.assertEqual(len([curve for curve in self.find(".curve") if curve.is_displayed()]), 1)  # one scalar
        points = lambda: self.find(".curve .color")
        self.assertEqual(len(points()), 2)
        self.element("add-color").click()
        self.wait_until(lambda: self.options().get("colors") == "0:#000000,0.5:#808080,1:#ffffff", "no point added")
        self.assertNotIn("colormap", self.options())
        self.browser.execute_script("""
            const input = document.getElementById("point-color");
            input.value = "#ff8000";
            for (const type of ["input", "change"]) input.dispatchEvent(new Event(type));""")
        self.wait_until(lambda: self.options().get("colors") == "0:#000000,0.5:#ff8000,1:#ffffff", "not painted")
        self.drag(".curve .color", 30, 0, index=1)
        position = lambda: float(self.options()["colors"].split(",")[1].split(":")[0])
        self.wait_until(lambda: 0.52 < position() < 0.9, "not dragged")
        dragged = position()
        self.press(".curve .color", 1, Keys.ARROW_RIGHT)
        self.wait_until(lambda: abs(position() - dragged - 0.02) < 1e-3, "not moved by a key")
        self.assert_undoable("colors")
        self.assert_kept()
        ramp = self.browser.execute_script("""
            const points = [...document.querySelectorAll(".curve .color")];
            points[0].scrollIntoView({block: "center", behavior: "instant"});
            const [first, second] = points.map((point) => point.getBoundingClientRect());
            return [(first.left + second.right) / 2, first.top + first.height / 2]""")
        pointer = ActionChains(self.browser)
        pointer.w3c_actions.pointer_action.move_to_location(*map(round, ramp))
        pointer.click().perform()
        self.wait_until(lambda: len(points()) == 4, "no point added by a click")
        self.press(".curve .color", 1, Keys.DELETE)
        self.wait_until(lambda: len(points()) == 3, "not removed by a key")
        self.press(".curve .color", 2, Keys.DELETE)
        self.wait_until(lambda: len(points()) == 2, "not removed by a key")
        focused = self.browser.execute_script("return document.activeElement.getAttribute('aria-label')")
        self.assertEqual(focused, "Colour point 2 of 2")  # the keyboard's place is kept
        self.choose("colormap", "viridis")
        self.wait_until(lambda: len(points()) == 9 and "colors" not in self.options(), "no map")

    def test_a_logarithmic_scale(self):
        self.open()
        lower, upper = (f"input[aria-label='Colour: {end} end of the range']" for end in ("lower", "upper"))
        ends = lambda: [float(self.find(end)[0].get_attribute("value")) for end in (lower, upper)]
        linear = ends()
        bars = lambda: self.browser.execute_script(
            "return [...document.querySelectorAll('.curve .bars')].map((bar) => bar.getAttribute('height')).join()")
        before = bars()
        self.element("option-color-scale").click()
        self.wait_until(lambda: self.options().get("color-scale") == "log" and bars() != before, "not logarithmic")
        self.assertGreater(ends()[0], 0)
        self.assertLess(abs(ends()[1] - linear[1]), 0.05 * linear[1])
        # The middle of the points lies at the geometric mean.
        point = self.browser.execute_script("""
            const points = [...document.querySelectorAll(".curve .point")];
            return points[(points.length - 1) / 2].getAttribute("aria-valuetext")""")
        low, high = ends()
        self.assertAlmostEqual(float(point.split()[-1]) / (low * high) ** 0.5, 1, delta=0.01)
        for text in "0", "0.2":  # the first is not taken
            self.find(lower)[0].send_keys(Keys.CONTROL + "a" + Keys.NULL + text + Keys.TAB)
        self.wait_until(lambda: self.options().get("range", [0])[0] == 0.2, "no range")
        self.wait_for_refined()
        self.assert_undoable("range")
        self.assert_kept()
        self.element("option-color-scale").click()
        self.wait_until(lambda: self.options().get("color-scale") == "linear", "not linear")

    def open_cuts(self):
        """Open the section of cuts, where handles are drawn."""
        self.browser.execute_script("document.getElementById('cut-handles').closest('details').open = true")

    def handle(self, name):
        """The selector of a handle over the picture, once it is there."""
        selector = f"#overlay [aria-label='{name}']"
        self.wait_until(lambda: len(self.find(selector)) == 1, f"no handle '{name}'")
        return selector

    def test_a_region_of_interest(self):
        self.open()
        self.open_cuts()
        self.element("region").click()
        self.wait_until(lambda: "roi-box" in self.options(), "no region")
        whole = self.options()["roi-box"]
        self.wait_for_refined()
        shown, side = self.pixels(), "Upper x side of the region"
        self.press(self.handle(side), 0, Keys.ARROW_LEFT)
        self.wait_until(lambda: self.options()["roi-box"][3] < whole[3], "not moved by a key")
        self.wait_for_refined()
        self.wait_until(lambda: self.pixels() != shown, "the picture is the same")
        pressed = self.options()["roi-box"]
        self.drag(self.handle(side), -60, 20)
        self.wait_until(lambda: self.options()["roi-box"] != pressed, "not dragged")
        self.assertEqual(self.options()["roi-box"][:3], whole[:3])
        self.wait_for_refined()
        self.assert_undoable("roi-box")
        self.assert_kept()
        self.open_cuts()
        self.element("region").click()
        self.wait_until(lambda: "roi-box" not in self.options(), "the region stays")

    def test_a_plane_is_tilted(self):
        self.open()
        self.open_cuts()
        normal = lambda: self.options()["clip-plane"][0][3:]
        length = lambda v: sum(c * c for c in v) ** 0.5
        self.browser.find_element(By.XPATH, "//details[@open]//button[text()='x']").click()
        self.wait_until(lambda: "clip-plane" in self.options(), "no plane")
        point = self.options()["clip-plane"][0][:3]
        self.assertEqual(normal(), [1, 0, 0])
        self.press(self.handle("Tilt of plane 1"), 0, Keys.ARROW_UP)
        self.wait_until(lambda: normal() != [1, 0, 0], "not turned by a key")
        turned = normal()
        self.assertAlmostEqual(length(turned), 1, places=4)
        self.assertGreater(turned[0], 0.99)  # by five degrees
        self.wait_for_refined()
        self.drag(self.handle("Tilt of plane 1"), -70, -40)
        self.wait_until(lambda: abs(normal()[0] - turned[0]) > 0.1, "not turned by hand")
        self.assertAlmostEqual(length(normal()), 1, places=4)
        self.assertEqual(self.options()["clip-plane"][0][:3], point)
        self.wait_for_refined()
        self.assert_undoable("clip-plane")
        self.assert_kept()

    def test_what_is_dragged_stays_under_the_hand(self):
        self.open()
        x_of = lambda selector: self.browser.execute_script("""
            const box = document.querySelector(arguments[0]).getBoundingClientRect();
            return box.left + box.width / 2""", selector)
        for selector, by in (".curve .grip[data-end='1']", -90), (".curve .point[data-index='3']", 15):
            with self.subTest(selector=selector):
                begin = x_of(selector)
                ActionChains(self.browser).click_and_hold(self.find(selector)[0]).perform()
                for _ in range(5):
                    ActionChains(self.browser, duration=20).move_by_offset(by // 5, 0).perform()
                    self.wait_for_refined()  # after the server's answers
                self.assertAlmostEqual(x_of(selector), begin + by, delta=3)
                ActionChains(self.browser).release().perform()
                self.wait_for_refined()
        # The automatic camera has become that of the state: it does not follow what is seen.
        eye = self.options()["eye"]
        self.open_cuts()
        self.element("cut-box").click()
        side = self.handle("Upper x side of the box")
        self.drag(side, -80, 0)
        self.wait_for_refined()
        self.assertEqual(self.options()["eye"], eye)
        self.browser.execute_script("document.getElementById('auto-view').click()")
        self.wait_until(lambda: "eye" not in self.options(), "not automatic")
        self.press("#overlay .handle", 0, Keys.ARROW_RIGHT)  # a cut alone
        self.wait_until(lambda: "eye" in self.options(), "automatic")

    def test_one_tab_stop_a_curve(self):
        self.open("--opacity-by", "q")
        curves = [curve for curve in self.find(".curve") if curve.is_displayed()]
        self.assertEqual(len(curves), 2)
        for curve in curves:
            self.assertEqual(len(curve.find_elements(By.CSS_SELECTOR, "[tabindex='0']")), 1)
        focused = lambda: self.browser.execute_script("return document.activeElement.getAttribute('aria-label')")
        self.press(".curve [tabindex='0']", 0, Keys.PAGE_DOWN)
        self.assertEqual(focused()[:14], "Colour point 2")
        ActionChains(self.browser).send_keys(Keys.END, Keys.ARROW_LEFT, Keys.PAGE_UP).perform()
        self.wait_until(lambda: "colors" in self.options(), "not moved")
        count = len(self.find(".curve .color"))
        self.assertEqual(focused(), f"Colour point {count - 1} of {count}")
        self.assertEqual(len(curves[0].find_elements(By.CSS_SELECTOR, "[tabindex='0']")), 1)

    def test_why_nothing_is_seen(self):
        self.open()
        says = lambda words: self.wait_until(lambda: words in self.element("message").text, f"no '{words}'")
        for options, words in (({"opacity": "0:0,1:0"}, "points of opacity"), ({"range": [50, 60]}, "Automatic"),
                               ({"clip-box": [90, 90, 90, 91, 91, 91]}, "under Cuts"),
                               ({"eye": [50, 50, 50], "target": [60, 60, 60]}, "Show all")):
            with self.subTest(options=options):
                self.browser.execute_script("location.hash = encodeURIComponent(JSON.stringify(arguments[0]))",
                                            {"frame": 1, "options": {"samples": 1, **options}})
                says(words)
                self.assertNotIn("--", self.element("message").text)

    def test_the_light_has_a_handle(self):
        self.open()
        self.browser.execute_script("document.getElementById('light-on').closest('details').open = true")
        self.element("light-on").click()
        self.wait_until(lambda: "light" in self.options(), "no light")
        before = self.options()["light"][0]
        self.press(self.handle("Direction of the light"), 0, Keys.ARROW_UP)
        self.wait_until(lambda: self.options()["light"][0] != before, "not turned by a key")
        turned = self.options()["light"][0]
        self.assertAlmostEqual(sum(c * c for c in turned), 1, places=4)
        self.drag(self.handle("Direction of the light"), 60, -40)
        self.wait_until(lambda: self.options()["light"][0] != turned, "not turned by hand")
        self.assert_undoable("light")
        self.assertEqual(len(self.options()["light"]), 1)

    def test_small_pictures_to_choose_from(self):
        self.open()
        pictures = lambda: [image.get_attribute("src") for image in self.find(".pick img")]
        self.wait_until(lambda: all(pictures()), "no small pictures")
        self.assertEqual(len(pictures()), 7)
        drawn = self.browser.execute_script("""
            return [...document.querySelectorAll(".pick img")].map((image) => {
                const canvas = Object.assign(document.createElement("canvas"), {width: 96, height: 64});
                canvas.getContext("2d").drawImage(image, 0, 0);
                return canvas.toDataURL();
            })""")
        self.assertGreaterEqual(len(set(drawn)), 6)
        # A look changes what it is named for: colours, range and the scalar of opacity stay.
        self.choose("colormap", "viridis")
        self.wait_until(lambda: self.options().get("colormap") == "viridis", "no map")
        opacity_by = lambda: self.element("option-opacity-by").get_property("value")
        for look, scalar in ("smoke", "magnitude"), ("vortex", "q"), ("paper", "q"):
            self.choose("look", look)
            self.wait_until(lambda: self.options().get("look") == look, "no look")
            self.wait_for_refined()
            self.assertEqual((self.options()["colormap"], opacity_by()), ("viridis", scalar))
            bright = self.browser.execute_script("return document.documentElement.matches('.bright')")
            self.assertEqual(bright, look == "paper")
        self.assertIn("Q criterion [1/s²]", self.browser.execute_script("""
            return [...document.querySelectorAll(".panel .name")].map((name) => name.textContent)"""))

    def test_a_look_without_its_data(self):
        """It cannot be chosen and says why; the pictures of the others are made."""
        self.outputs("vdblic_advect", self.data / "v.%04d.vdb", "-o", "plain.%04d.vdb", "--frames", "1-2")
        self.start("plain.%04d.vdb")
        self.browser.get(self.address)
        self.wait_for_refined()
        self.wait_for_small_pictures(1)
        states = self.browser.execute_script("""
            return [...document.querySelectorAll("#option-look label")].map((label) => [
                label.querySelector("input").value, label.querySelector("input").disabled, label.title,
                Boolean(label.querySelector("img").src)])""")
        for look, disabled, title, has_picture in states:
            self.assertEqual((disabled, has_picture), (look == "vortex", look != "vortex"), look)
            self.assertEqual("q" in title, disabled, title)
        self.assertEqual(self.element("message").text, "")
        refused = [entry["message"] for entry in self.browser.get_log("browser")]
        self.assertTrue(all("422" in message for message in refused), refused)

    def test_help(self):
        """It opens at every width, and closes by a key and by a click beside it."""
        self.open()
        is_open = lambda: self.browser.execute_script("return document.getElementById('help-text').matches(':popover-open')")
        self.element("help").click()
        self.assertTrue(is_open())
        self.browser.execute_script("document.activeElement.blur()")
        ActionChains(self.browser).send_keys("?").perform()
        self.assertFalse(is_open())

    def test_undo_everywhere(self):
        self.open()
        undo = lambda: ActionChains(self.browser).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
        gone = lambda name: self.wait_until(lambda: name not in self.options(), f"{name} is not undone")
        # In a menu.
        Select(self.element("option-color-by")).select_by_visible_text("q")
        self.wait_until(lambda: self.options().get("color-by") == "q", "no scalar")
        self.browser.execute_script("document.getElementById('option-color-by').focus()")
        undo()
        gone("color-by")
        # In a field: what is typed is the field's, what was taken is undone.
        field = self.find("input[aria-label='Colour: upper end of the range']")[0]
        before = field.get_attribute("value")
        field.send_keys(Keys.CONTROL + "a" + Keys.NULL + "2.5")
        undo()
        self.assertNotIn("range", self.options())
        field.send_keys(Keys.CONTROL + "a" + Keys.NULL + "2.5" + Keys.ENTER)
        self.wait_until(lambda: self.options().get("range", [0, 0])[1] == 2.5, "no range")
        undo()
        gone("range")
        self.wait_until(lambda: field.get_attribute("value") == before, "the field is not undone")
        # A movement of the wheel is one step.
        def turn_wheel():
            hand = ActionChains(self.browser, duration=20)
            for _ in range(6):
                hand.scroll_from_origin(ScrollOrigin.from_element(self.element("picture")), 0, 20)
            hand.perform()
        turn_wheel()
        self.wait_until(lambda: "eye" in self.options(), "not zoomed")
        zoomed = self.options()["eye"]
        turn_wheel()
        self.wait_until(lambda: self.options()["eye"] != zoomed, "not zoomed")
        self.element("picture").click()
        undo()
        self.wait_until(lambda: self.options().get("eye") == zoomed, "not undone")
        undo()
        gone("eye")
        # The right button removes a point, and opens no menu.
        self.browser.execute_script("""
            window.menus = 0;
            addEventListener("contextmenu", (event) => { menus += !event.defaultPrevented; });""")
        points = len(self.find(".curve .point"))
        ActionChains(self.browser).context_click(self.find(".curve .point")[2]).perform()
        self.wait_until(lambda: len(self.find(".curve .point")) == points - 1, "not removed")
        self.assertEqual(self.browser.execute_script("return menus"), 0)

    def test_key_frames_are_kept_as_shown(self):
        self.open()
        self.browser.execute_script("document.getElementById('add-key').closest('details').open = true")
        self.element("add-key").click()
        self.wait_until(lambda: "keys" in self.options(), "no key")
        self.drag("#picture", 120, 20)
        self.wait_for_refined()
        state = self.options()
        state["size"] = self.browser.execute_script(
            "const {width, height} = document.getElementById('picture'); return [width, height]")
        self.element("keep-png").click()
        self.wait_until(lambda: "Saved" in self.element("kept").text, "no picture was kept")
        shown, of_keys = ({**state, "keys": keys} for keys in (None, state["keys"]))
        del shown["keys"]
        self.assertEqual(self.contents("view-001.png"), self.picture(shown))
        # Following the keys is in the address.
        self.browser.execute_script("document.getElementById('follow-keys').click()")
        self.wait_for_refined()
        self.browser.refresh()
        self.wait_for_refined()
        self.assertTrue(self.element("follow-keys").is_selected())
        self.element("keep-png").click()
        self.wait_until(lambda: "view-002" in self.element("kept").text, "no picture was kept")
        self.assertEqual(self.contents("view-002.png"), self.picture(of_keys))
        self.assertNotEqual(self.contents("view-001.png"), self.contents("view-002.png"))
        # The hand takes the camera over where it is.
        self.element("picture").click()
        self.wait_for_refined()
        self.assertFalse(self.element("follow-keys").is_selected())
        self.assertEqual(self.options()["eye"], state["keys"][0]["eye"])

    def test_a_long_job_tells_how_far_it_is(self):
        self.open("--samples", 4)
        for name in "keep-width", "keep-height":
            self.element(name).send_keys("3000")
        self.element("keep-png").click()
        self.wait_until(lambda: "of 4 samples" in self.element("jobs").text, "no progress")
        self.element("picture").send_keys(".")  # the picture goes on
        self.wait_until(lambda: self.element("picture").get_attribute("data-frame") == "2", "no step")
        self.find("[aria-label='Stop view-001.png']")[0].click()
        self.wait_until(lambda: "view-001.png: stopped" in self.element("kept").text, "not stopped")
        self.assertEqual(self.element("jobs").text, "")
        self.assertNotIn("view-001.png", self.files())

    def test_frames_come_and_go(self):
        self.open()
        number = lambda: self.element("frame-number").text.split(",")[0]
        self.element("picture").send_keys(",")
        self.wait_until(lambda: number() == "frame 3 of 3", "no step back")
        self.wait_for_refined()
        # Pictures of looks that are under way when their frame goes would be errors of the network.
        self.browser.execute_script(FOCUS, "#option-look input", 0)
        self.wait_for_small_pictures(3)
        # Whoever looks at the newest frame goes on to newer ones.
        (self.folder / "lic.0003.vdb").unlink()
        self.wait_until(lambda: number() == "frame 2 of 2", "the frame is not gone")
        (self.folder / "lic.0005.vdb").hardlink_to(self.folder / "lic.0001.vdb")  # at once
        self.wait_until(lambda: number() == "frame 5 of 5", "no growth")
        self.wait_for_refined()
        shown = self.pixels()
        (self.folder / "new").write_bytes(self.contents("lic.0002.vdb"))
        (self.folder / "new").rename(self.folder / "lic.0005.vdb")
        self.wait_until(lambda: self.pixels() != shown, "the picture is stale")

    def test_small_pictures_are_of_the_shown_frame(self):
        """Also if another one is shown while they are made."""
        self.open()
        self.wait_for_small_pictures(1)
        self.browser.execute_script("""
            const ask = window.fetch, released = new Promise((release) => { window.release = release; });
            window.held = 0;
            window.fetch = async (...asked) => {
                if (asked[0] === "thumbnail" && ++window.held) await released;
                return ask(...asked);
            };""")
        self.press("#option-look input", 0, ".")
        self.wait_until(lambda: self.browser.execute_script("return held") == 1, "no small picture is asked for")
        self.element("picture").send_keys(".")  # and nobody turns to them any more
        self.wait_for_refined()
        self.browser.execute_script("release()")
        self.wait_for_small_pictures(3)

    def test_a_server_that_answers_again(self):
        """What found no server is asked for once more, without the user."""
        self.open()
        self.wait_for_small_pictures(1)
        self.element("picture").send_keys(".")
        self.wait_for_refined()
        self.browser.execute_script("""
            const ask = window.fetch;
            window.lost = new Set();
            window.fetch = (...asked) =>
                window.lost?.add(asked[0]) ? Promise.reject(new TypeError("no server")) : ask(...asked);""")
        self.browser.execute_script(FOCUS, "#option-look input", 0)
        asked = lambda: set(self.browser.execute_script("return [...lost]"))
        self.wait_until(lambda: {"thumbnail", "status"} <= asked(), "nothing is asked for")
        self.assertIn("does not answer", self.element("message").text)
        self.browser.execute_script("document.activeElement.blur(); lost = null")
        self.wait_for_small_pictures(2)
        self.assertEqual(self.element("message").text, "")

    def test_time_goes_on(self):
        self.open()
        frame = lambda: int(self.element("picture").get_attribute("data-frame"))
        self.assertEqual(frame(), 1)
        self.element("picture").send_keys(".")
        self.wait_until(lambda: frame() == 2, "no step")
        seen = set()
        self.element("play").click()
        self.wait_until(lambda: seen.add(frame()) or seen == {1, 2, 3}, "no play")
        self.element("picture").send_keys(" ")
        self.assertEqual(self.element("play").get_attribute("aria-pressed"), "false")

    def test_looks_cuts_and_keys(self):
        self.open("--look", "xray")
        self.assertTrue(self.element("look-xray").is_selected())
        self.choose("look", "vortex")
        self.wait_for_refined()
        self.wait_until(lambda: Select(self.element("option-opacity-by")).first_selected_option.text == "q", "not by q")
        self.assertEqual(len([curve for curve in self.find(".curve") if curve.is_displayed()]), 2)
        for summary in self.find("details:not([open]) summary"):
            self.browser.execute_script("arguments[0].click()", summary)
        self.element("cut-box").click()
        self.wait_until(lambda: len(self.find("#overlay .handle")) == 6, "no handles")
        self.wait_until(lambda: "clip-box" in self.options(), "no box")
        before = self.options()["clip-box"]
        self.press("#overlay .handle", 0, Keys.ARROW_RIGHT)
        self.wait_until(lambda: self.options()["clip-box"] != before, "not moved")
        self.element("add-key").click()
        self.wait_for_refined()
        self.assertEqual([key["frame"] for key in self.options()["keys"]], [1])

    def test_without_a_mouse(self):
        self.open()
        self.browser.execute_script("document.getElementById('picture').focus()")
        ActionChains(self.browser).send_keys(Keys.ARROW_LEFT, "+", ".").perform()
        self.wait_for_refined()
        self.assertIn("eye", self.options())
        self.assertEqual(self.element("picture").get_attribute("data-frame"), "2")
        # All is shown in the same direction, from elsewhere.
        direction = lambda: [round(b - a, 3) for a, b in zip(self.options()["eye"], self.options()["target"])]
        length = lambda v: sum(c * c for c in v) ** 0.5
        near, eye = direction(), self.options()["eye"]
        ActionChains(self.browser).send_keys("0").perform()
        self.wait_until(lambda: self.options()["eye"] != eye, "all is not shown")
        far = direction()
        self.assertAlmostEqual(sum(a * b for a, b in zip(near, far)) / length(near) / length(far), 1, places=4)
        self.browser.execute_script("document.getElementById('auto-view').click()")
        self.wait_until(lambda: "eye" not in self.options(), "not automatic")
        # Everything that takes the focus has a name.
        unnamed = self.browser.execute_script("""
            return [...document.querySelectorAll("button, input, select, [tabindex]")].filter((e) => !(
                e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.length)).map((e) => e.outerHTML)""")
        self.assertEqual(unnamed, [])

    def test_narrow_screens(self):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": 360, "height": 640, "deviceScaleFactor": 2, "mobile": True})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.open()
        widest = self.browser.execute_script("return document.documentElement.scrollWidth")
        self.assertLessEqual(widest, 360)
        # Rows are as wide as the panel, and no number is cut off.
        for summary in self.find("details:not([open]) summary"):
            self.browser.execute_script("arguments[0].click()", summary)
        cut = self.browser.execute_script("""
            return [...document.querySelectorAll("#panel details > div, #panel .row > *, #panel .line > *")]
                .filter((e) => e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0
                    || e.getBoundingClientRect().right > innerWidth).map((e) => e.outerHTML.slice(0, 200))""")
        self.assertEqual(cut, [])
        self.assertGreater(self.element("picture").size["height"], 200)
        # The picture stays where it is while the settings below it move.
        top = "return document.getElementById('picture').getBoundingClientRect().top"
        before = self.browser.execute_script(top)
        self.browser.execute_script("document.getElementById('keep-exr').scrollIntoView({behavior: 'instant'})")
        self.assertEqual(self.browser.execute_script(top), before)


if __name__ == "__main__":
    unittest.main()
