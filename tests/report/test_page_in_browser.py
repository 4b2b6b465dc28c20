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
window.onerror = (message) => { document.title = JSON.stringify({ fault: String(message) }); };
setTimeout(() => {
  const canvas = document.querySelector("canvas"), gl = canvas.getContext("webgl2");
  const pixels = new Uint8Array(4 * canvas.width * canvas.height), colours = new Set();
  if (gl) gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  for (let k = 0; k < pixels.length; k += 4) colours.add(pixels.slice(k, k + 3).join());
  document.querySelectorAll("table.sorted th").forEach((head) => head.click());
  const broken = [...document.images].filter((image) => image.complete && !image.naturalWidth);
  document.title = JSON.stringify({ width: innerWidth, scrolled: document.scrollingElement.scrollWidth,
    colours: colours.size, increments: document.querySelectorAll("option[value='0']").length,
    broken: broken.length, images: document.images.length, webgl: Boolean(gl),
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
    assert main(["report", str(folder), "--campaign", asked(folder, ["one"]), "-o", str(page)]) == 0
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
    command += ["--hide-scrollbars", f"--window-size={width},1000", "--virtual-time-budget=6000"]
    command += [f"--user-data-dir={path.parent / 'profile'}", "--host-resolver-rules=MAP * ~NOTFOUND"]
    done = subprocess.run(
        [*command, "--dump-dom", path.as_uri()], capture_output=True, text=True, timeout=240
    )
    title = re.search("<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert title, done.stderr[-2000:]
    return json.loads(html.unescape(title[1]))


@pytest.mark.parametrize("width, dark", [(500, False), (900, True), (1400, False)])
def test_it_opens_without_faults_and_fits_the_window(path, width, dark):
    seen = look(path, width, dark)
    assert "fault" not in seen and seen["text"]
    assert (seen["ground"] != "rgb(255, 255, 255)") == dark
    assert seen["width"] == width and seen["scrolled"] <= width
    assert seen["broken"] == 0 and seen["images"] == 5
    if not seen["webgl"]:
        pytest.skip("this Chromium has no WebGL 2")
    # two grains, the crack, its front, the ground, and these through each other
    assert seen["colours"] > 8 and seen["increments"] == 1
