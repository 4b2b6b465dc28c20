"""The page in headless Chromium: at three widths, light or dark, without a network; the view draws."""

import html
import json
import re
import shutil
import subprocess

import pytest
from shown_models import asked, write_front, write_increment

from craftmesh.cli import main

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
# Looks at the page once it stands, and says what it saw where --dump-dom shows it.
LOOK = """<script>
const width = Number(location.hash.slice(1)); // a window of Chromium is 500 wide at least
document.documentElement.style.width = `${width}px`;
window.onerror = (message) => { document.title = JSON.stringify({ fault: String(message) }); };
function colour(text) {
  const [red, green, blue, alpha = 1] = text.match(/[\\d.]+/g).map(Number);
  return { shades: [red, green, blue], alpha };
}
function luminance({ shades }) {
  const curve = (s) => (s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4);
  const linear = shades.map((s) => curve(s / 255));
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}
function contrast(element) {
  const below = (one) => colour(getComputedStyle(one).backgroundColor);
  let ground = element;
  while (below(ground).alpha === 0 && ground !== document.body) ground = ground.parentElement;
  const style = getComputedStyle(element), ink = element instanceof SVGElement ? style.fill : style.color;
  const pair = [colour(ink), below(ground)].map(luminance);
  return (Math.max(...pair) + 0.05) / (Math.min(...pair) + 0.05);
}
setTimeout(() => {
  const canvas = document.querySelector("canvas"), gl = canvas.getContext("webgl2");
  const pixels = new Uint8Array(4 * canvas.width * canvas.height), colours = new Set();
  if (gl) gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  for (let k = 0; k < pixels.length; k += 4) colours.add(pixels.slice(k, k + 3).join());
  const buttons = [...document.querySelectorAll("table.sorted th button")];
  buttons.forEach((button) => button.click());
  const texts = [...document.querySelectorAll("body *")].filter((one) => one.getClientRects().length
    && [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())
    && !one.closest("script, style, select, button, input"));
  const faint = texts.filter((one) => contrast(one) < 4.5).map((one) => one.textContent.trim());
  const wide = [...document.querySelectorAll("body *")].filter((one) => !one.closest(".wide, svg, details")
    && one.getBoundingClientRect().right > width + 1).map((one) => one.tagName);
  const failures = document.querySelector("#failures .wide");
  const tops = (row) => [...row.children].map((panel) => Math.round(panel.getBoundingClientRect().top));
  const rows = [...document.querySelectorAll(".panels")].map(tops);
  const panels = rows.map((row) => new Set(row).size / row.length);
  document.title = JSON.stringify({ faint, wide, panels, texts: texts.length, colours: colours.size,
    increments: document.querySelectorAll("option[value='0']").length,
    pictures: document.querySelectorAll("svg").length, webgl: Boolean(gl),
    wrapped: failures.scrollWidth <= failures.clientWidth + 1,
    reached: buttons.every((button) => button.tabIndex === 0),
    text: document.body.innerText.includes("Case one"),
    ground: getComputedStyle(document.body).backgroundColor });
}, 1500);
</script>"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_increment(folder / "one" / "000")
    write_front(folder / "one" / "000", [1.0, 2.0, 3.0])
    page = folder / "report.html"
    log = folder / "logs" / "two" / "000" / "crack.log"
    log.parent.mkdir(parents=True)
    log.write_text(
        "craftmesh: error: the crack lies along the box face YMIN; " + 9 * "move it inward " + "\n"
    )
    assert main(["report", str(folder), "--campaign", asked(folder, ["one", "two"]), "-o", str(page)]) == 0
    page.write_text(page.read_text().replace("<style>", LOOK + "<style>", 1))
    return page


def look(path, width, dark):
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ]
    command += ["--blink-settings=preferredColorScheme=0"] if dark else []
    command += ["--hide-scrollbars", f"--window-size={max(width, 500)},1000", "--virtual-time-budget=6000"]
    command += [f"--user-data-dir={path.parent / 'profile'}", "--host-resolver-rules=MAP * ~NOTFOUND"]
    done = subprocess.run(
        [*command, "--dump-dom", f"{path.as_uri()}#{width}"], capture_output=True, text=True, timeout=240
    )
    title = re.search("<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert title, done.stderr[-2000:]
    return json.loads(html.unescape(title[1]))


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [400, 900, 1400])
def test_it_opens_without_faults_is_read_and_fits_the_window(path, width, dark):
    seen = look(path, width, dark)
    assert "fault" not in seen and seen["text"] and seen["reached"]
    assert (seen["ground"] != "rgb(255, 255, 255)") == dark
    assert seen["wide"] == [] and seen["wrapped"]
    assert seen["texts"] > 50 and seen["faint"] == []
    assert (
        seen["pictures"] == 3 + 1 + 4 + 3
    )  # of the body, the crack's path, K and the kink angle, histograms
    if width == 400:
        assert set(seen["panels"]) == {1}, "each panel has a row"
    if not seen["webgl"]:
        pytest.skip("this Chromium has no WebGL 2")
    # two grains, the crack, its front, the ground, and these through each other
    assert seen["colours"] > 8 and seen["increments"] == 1
