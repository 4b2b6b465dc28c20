import os
import sys
from pathlib import Path

from snakemake.utils import min_version

from craftmesh.campaign.campaign import command_flags, read_campaign
from craftmesh.errors import CraftmeshError

min_version("9.8")


# a campaign of one's own (--configfile) starts from the schema's defaults, never from the demo's values
if not workflow.overwrite_configfiles:

    configfile: "config/config.yaml"


try:
    CAMPAIGN = read_campaign(config, Path(workflow.basedir) / "workflow" / "schemas")
except CraftmeshError as error:
    sys.exit(f"craftmesh: error: {error}")

# the rules' shell finds the `craftmesh` command beside the Python that runs Snakemake
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

CASE = f"{CAMPAIGN.results}/{{case}}"
INC = f"{CASE}/{{inc}}"
LOG = f"{CAMPAIGN.results}/logs/{{case}}"
BENCHMARK = f"{CAMPAIGN.results}/benchmarks/{{case}}"


wildcard_constraints:
    case="[^/]+",
    inc=r"\d{3}",
    part=r"\d+",
    parts=r"\d+",


include: "workflow/rules/microstructure.smk"
include: "workflow/rules/crack.smk"
include: "workflow/rules/surface.smk"
include: "workflow/rules/volume.smk"
include: "workflow/rules/deck.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        [CAMPAIGN.increments(file) for file in CAMPAIGN.deck_files(f"{INC}/model.inp")],
        [CAMPAIGN.increments(file) for file in CAMPAIGN.exports(f"{INC}/model.inp")],
        CAMPAIGN.increments(f"{INC}/quality.json"),
        f"{CAMPAIGN.results}/report.html",
