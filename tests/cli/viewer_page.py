"""Shared by the tests of vdblic_view's page: a browser without a screen."""

import json
import re
import shutil

from support import skip

try:
    from selenium import webdriver
except ImportError:
    skip("python3-selenium is not installed")
if not shutil.which("chromium") or not shutil.which("chromedriver"):
    skip("chromium is not installed")

from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

from viewer import ViewerTest


# What the page does later, such as writing its state into the address, and what it asks for; not what it repeats every
# second and a half.
WAITING = """
    const waiting = new Set(), later = setTimeout, never = clearTimeout, ask = fetch;
    window.setTimeout = (act, delay) => {
        const timer = later(() => { waiting.delete(timer); act(); }, delay);
        if (delay < 1000) waiting.add(timer);
        return timer;
    };
    window.clearTimeout = (timer) => { waiting.delete(timer); never(timer); };
    window.fetch = (...asked) => {
        const answer = ask(...asked);
        if (asked[0] !== "status") {
            waiting.add(answer);
            const end = () => later(() => waiting.delete(answer), 0);
            answer.then(end, end);
        }
        return answer;
    };
    window.waiting = waiting;
"""


def browser(flags):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     "--window-size=900,700", *flags):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


class BrowserTest(ViewerTest):
    """A test case with a browser, which has additional `flags`."""

    flags = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser(cls.flags)
        cls.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WAITING})
        cls.addClassCleanup(cls.browser.quit)

    def open(self, *arguments, source="lic.%04d.vdb"):
        self.start(source, *arguments)
        self.browser.get(self.address)
        self.wait_for_refined()

    def complaints(self):
        """What the browser says of the page."""
        return [entry for entry in self.browser.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def stop(self):
        """The page leaves first: it would complain of a viewer that is gone."""
        self.browser.get("about:blank")
        return super().stop()

    def tearDown(self):
        self.browser.get("about:blank")
        self.assertEqual(self.complaints(), [])
        super().tearDown()

    def element(self, name):
        return self.browser.find_element(By.ID, name)

    def wait_until(self, condition, what, seconds=120):
        try:
            super().wait_until(condition, what, seconds)
        except AssertionError:
            self.fail(f"{what}; the page says: {self.element('message').text}")

    def options(self):
        """The options in the address."""
        text = self.browser.execute_script("return decodeURIComponent(location.hash.slice(1))")
        return json.loads(text)["options"] if text else {}

    def wait_until_at_rest(self):
        """Wait until the page waits for nothing but the user."""
        self.wait_until(lambda: self.browser.execute_script("return waiting.size") == 0, "the page is not at rest")

    def wait_for_refined(self):
        """Wait until the picture of the state is there with all its samples. Opens two sections."""
        self.wait_until_at_rest()
        self.browser.execute_script("""
            for (const name of ["automatic", "keep-files"])
                if (document.getElementById(name)) document.getElementById(name).closest("details").open = true""")
        progress = lambda: self.element("progress").get_attribute("textContent")
        self.wait_until(lambda: re.match(r"(\d+) of \1 samples", progress()), "not refined")

    def find(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def pixels(self):
        return self.browser.execute_script("return document.getElementById('picture').toDataURL()")
