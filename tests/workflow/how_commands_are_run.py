"""Where a test runs each command of the documentation, and in which words, or why none does.

The fences of the guide and those of the README's "Your own data" are run line by line as they stand.
"""

RUN = "snakemake -s $(craftmesh snakefile) --cores all"
SCAN = "--configfile scan.yaml"
# in the guide's folder, after its fences
IN_THE_GUIDE = {
    "craftmesh --help": "craftmesh --help",
    "craftmesh SUBCOMMAND --help": "craftmesh gradate --help",
    "craftmesh snakefile": "craftmesh snakefile",
    "craftmesh completion bash": "craftmesh completion bash",
    "craftmesh generate --shape 48 40 44 --grains 20 --voids 1 -o generated.npz": "",
    "craftmesh import-config config.xml -o config.yaml": "",
    "craftmesh preview remeshed.vtp crack.vtp -o crack.png": "",
    "craftmesh check FILE": "craftmesh check volume.vtu",
    "craftmesh check gradated.vtp": "",
    "craftmesh check model.inp": "",
    "craftmesh view FILE -o picture.png": "craftmesh view gradated.vtp -o picture.png",
    "craftmesh assemble gradated.vtp part-*.npz --sizing sizing.npz -o volume.vtu --front-csv front.csv": (
        "for k in 1 2; do craftmesh tetrahedralize gradated.vtp --islands islands.json --sizing sizing.npz"
        " --chunk $k/2 -o part-$k.npz || exit 1; done;"
        " craftmesh assemble gradated.vtp part-*.npz --sizing sizing.npz -o whole.vtu --front-csv whole.csv"
        " && cmp volume.vtu whole.vtu && cmp front.csv whole.csv"
    ),
    "craftmesh inp volume.vtu --microstructure labels.npz --user-material oxford --magnitude 0.005"
    " --steps triangle:1,R=-1,cycles=3 --output-every 5 -o model.inp": "",
    "craftmesh inp volume.vtu --microstructure labels.npz --user-material copper.yaml -o model.inp": (
        "cp \"$(python -c 'from craftmesh.io.user_material import FOLDER; print(FOLDER)')/huang.yaml\""
        " copper.yaml"
        " && craftmesh inp volume.vtu --microstructure labels.npz --user-material copper.yaml -o model.inp"
    ),
    "python -m craftmesh.campaign.config_schema craftmesh/campaign/schemas/config.schema.yaml": (
        "python -m craftmesh.campaign.config_schema config.schema.yaml"
        " && cmp config.schema.yaml $ROOT/craftmesh/campaign/schemas/config.schema.yaml"
    ),
}
# lines of the guide's fences that are run elsewhere: the guide's folder has no campaign
NOT_IN_THE_GUIDE = ("craftmesh report results -o results/report.html",)
# in the folder of the README's "Your own data", after its fence
IN_YOUR_OWN_DATA = {
    "craftmesh plan scan.yaml --cores 4": "",
    "craftmesh plan mine.yaml": "craftmesh plan scan.yaml",
    "craftmesh run mine.yaml": "craftmesh run scan.yaml",
    "craftmesh run mine.yaml --profile profiles/slurm": (
        "craftmesh run scan.yaml --profile $ROOT/profiles/default --snakemake --cores 2"
    ),
    "craftmesh status results": "",
    "craftmesh clean results --dry-run": "",
    "craftmesh gradate results/notch/001/surface.vtp --sizing results/notch/001/sizing.npz -o try.vtp": (
        "craftmesh gradate results/scan/000/surface.vtp --sizing results/scan/000/sizing.npz -o try.vtp"
    ),
    "craftmesh clean results": "",
    "craftmesh report results -o results/report.html": "",
    "snakemake -s $(craftmesh snakefile) --cores all --configfile mine.yaml": f"{RUN} {SCAN}",
    "snakemake --cores all results/{case}/{inc}/solution.npz --configfile mine.yaml": (
        f"{RUN} results/scan/000/solution.npz {SCAN}"
    ),
    "snakemake --cores all results/{case}/{inc}/sif.csv --configfile mine.yaml": (
        f"{RUN} results/scan/000/sif.csv {SCAN}"
    ),
}
# in a copy of the tree, one after another, by stages that end at once; the meshes are made elsewhere
IN_THE_TREE = {
    "snakemake -n": "",
    "snakemake --dry-run": "",
    "snakemake --cores all": "",
    "snakemake --cores all -R tetrahedralize": "",
    "snakemake --summary": "",
    "snakemake -n -p": "",
    "snakemake --cores 1 --touch": "",
    "snakemake --cores all --rerun-triggers mtime input": "",
    "snakemake --unlock": "",
    "snakemake --lint": "",
    "snakemake --cores 1 --directory .test": "",
    "snakemake --cores 2 --configfile examples/al1050/growth.yaml": "",
    "snakemake --cores 2 --configfile examples/copper/growth.yaml": "",
}
BENCHMARKS = "benchmarks/test_benchmarks.py"
# what other tests run, of the commands that begin so
BY_OTHER_TESTS = {
    "craftmesh compile": "commands/test_compile.py::test_every_stage_runs_and_nothing_is_left_behind",
    "craftmesh export volume.vtu -o model.e": (
        "io/test_export.py::test_moose_gets_a_row_of_angles_for_each_block"
    ),
    "craftmesh check model.e": "io/test_export.py::test_check_reads_exodus_and_finds_what_is_wrong_in_it",
    "snakemake --cores 1 --touch results/notch": "workflow/test_reruns.py::test_what_is_there_is_accepted",
    **dict.fromkeys(
        (
            "snakemake --cores all -f results/",
            "snakemake --cores all -R results/notch/",
            "snakemake --cores all -R results/grown/",
            "snakemake --cores all -R inp",
            "snakemake --cores all -R remesh",
        ),
        "workflow/test_reruns.py::test_commands_of_the_cookbook_plan_the_jobs_that_it_names",
    ),
    **dict.fromkeys(
        (
            f"snakemake --cores 2 --configfile examples/{config}.yaml"
            for config in (
                *("al1050/config", "al6xn/config", "coalescing/config", "coalescing/growth"),
                *("copper/config", "intergranular/config", "measured_crack/config", "overhang/config"),
                "spectrum/config",
            )
        ),
        "workflow/test_examples.py::test_example_gives_decks_without_fault",
    ),
    "snakemake --profile profiles/slurm": (
        "workflow/test_slurm.py::test_a_campaign_killed_in_the_middle_goes_on_to_the_bytes_of_a_local_run"
    ),
    "ccx ": "stages/test_calculix.py::test_a_crack_opens",
    **dict.fromkeys(
        (
            f"craftmesh view results/{case}/"
            for case in ("coalescing_grown/003", "intergranular/001", "overhang/000")
        ),
        "commands/test_view.py::test_every_stage_file_has_a_picture",
    ),
    "craftmesh renew ": "workflow/test_renewal_run.py::test_each_mesh_keeps_elements_of_the_one_before",
    "python examples/notebooks/execute.py": (
        "test_notebooks.py::test_a_pyvista_mesh_becomes_a_deck_with_an_open_crack"
    ),
    "python examples/tutorial/t1.py": "test_tutorial_steps.py::test_each_mesh_is_sound",
    "make docs": "test_site.py::test_links_and_pictures_lead_to_files",
    # larger cases take hours: the scripts run on their smallest
    "python benchmarks/gradation.py": f"{BENCHMARKS}::test_gradation_measures_a_gradated_surface",
    "python benchmarks/volume.py": f"{BENCHMARKS}::test_volume_compares_ours_with_plain_tetgen",
    "python benchmarks/deck.py": f"{BENCHMARKS}::test_deck_measures_the_model_in_every_form",
    "python benchmarks/noise.py": (
        f"{BENCHMARKS}::test_noise_takes_a_volume_through_the_chain_as_it_is_and_smoothed"
    ),
    "python benchmarks/workflow_overhead.py": (
        "benchmarks/test_workflow_overhead.py::test_gaps_between_stages_are_counted_once"
    ),
    **dict.fromkeys(
        (
            f"python benchmarks/{name}.py"
            for name in ("solve", "fracture", "inclusion", "random_cracks", "random_growth", "living")
        ),
        "workflow/test_shown_commands.py::test_benchmarks_run_on_their_smallest_case",
    ),
}
SMALLEST = (
    "solve.py --case tiny --runs 1",
    "fracture.py --case penny --edges 3 --json figures.json",
    "inclusion.py --radius 5 --edge 2",
    "random_cracks.py 7 7 --keep folder",
    "random_cracks.py 0 0 --workers 2 --json rows.jsonl --resume --markdown random_cracks.md",
    "random_growth.py 8 8 --kinds --increments 1 --keep folder",
    "living.py tiny 2",
)
# what no test runs, by how it begins, and why
NOT_RUN = {
    "make demo": "minutes; craftmesh compile and snakemake --cores all are run elsewhere",
    "make setup": "it makes the environment in which the tests run",
    "make test": "it runs the tests",
    "make lint": "it runs ruff, mypy and snakefmt, and what is run elsewhere",
    "make bench": "hours",
    "make wheel": "three minutes of compilation; a slow test of test_wheel.py builds such a wheel",
    "make speed": "its result depends on the machine; test_speed.py holds its arithmetic",
    "python benchmarks/speed.py": "as that",
    "python benchmarks/scale.py": "minutes to hours; test_scale.py runs a small size",
    "make paper": "hours",
    "snakemake --cores 2 --configfile examples/paper_": "minutes to hours each",
    "snakemake intensities all --cores 2 --configfile examples/paper_": "as that",
    "snakemake --cores 2 --configfile examples/plastic": "it needs CalculiX",
    "craftmesh solve volume.vtu --microstructure labels.npz --user-material single_crystal": "as that",
    "python benchmarks/growth.py": "15 increments of a solved campaign: an hour",
    "python benchmarks/ablate.py": "25 CPU minutes; test_ablate.py holds its rows and what it compares",
    "python benchmarks/mutate.py": "minutes to hours; test_mutate.py holds what becomes of its faults",
    "python benchmarks/paper.py": "minutes to hours; test_paper.py holds its arithmetic",
    "pip install": "it would change the environment; test_wheel.py installs into one of its own",
    "pip wheel": "test_wheel.py builds the wheel",
    "snakemake --sdm conda": "it needs conda, and packages from the network",
    "apptainer exec": "it needs Apptainer and a container",
    "abaqus ": "it needs Abaqus",
}
