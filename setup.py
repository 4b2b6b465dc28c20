"""The workflow and the demo lie at the top of the tree; a wheel carries them inside the package."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

# Snakemake finds profiles/default beside the Snakefile that it is given
PLACES = {
    "workflow": "craftmesh/workflow",
    "profiles": "craftmesh/workflow/profiles",
    "config": "craftmesh/config",
}


class BuildWithWorkflow(build_py):
    """Build the package, then copy the workflow into it; an editable install uses the tree's own."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            for folder, place in PLACES.items():
                self.copy_tree(folder, str(Path(self.build_lib) / place))


setup(cmdclass={"build_py": BuildWithWorkflow})
