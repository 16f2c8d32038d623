"""The program and its peers on one case: each contender is a function that makes a model of the same contours once and returns what it
cost, with the command that judges the model. This process stays small: what a process is told of its peak memory counts its parent's.
"""
import json

from common import SOURCE, Failure, note, run

# Mesh_3 bounds circumradii, not edges. In our target edge lengths; these give the mean edge length that ours has.
FACET_RADIUS, CELL_RADIUS, FACET_DISTANCE, SURFACE_ERROR = 0.7, 0.7, 0.1, 0.02


PYTHON = "/usr/bin/python3"
JUDGE_LIMIT = 600  # seconds
CGAL_MESHING = ("insert", "refine", "slivers")  # of its stages; reading, contours and field are ours


class Case:
    """Contours of `words` (input and options of reading). Models and surfaces stand in `folder`, which is its own."""

    def __init__(self, program, build, words, folder, limit):
        self.program, self.build, self.words = program, build, words
        self.folder, self.limit = folder, limit
        self.contours = folder / "kept.vtp"
        self.size = None

    def prepare(self):
        """One model of ours: the target edge length of all, the kept contours that all are judged by; warms the file cache."""
        first = self.ours(more=["--contours", self.contours])
        self.size = first["size_mm"]
        self.write_surface("ours", first["model"])

    def write_surface(self, whose, model):
        run([PYTHON, SOURCE / "bench/interfaces.py", model, self.folder / whose], JUDGE_LIMIT)

    def ours(self, threads=1, more=()):
        report, model = self.folder / "ours.report.json", self.folder / f"ours-{threads}.vtu"
        done = run([self.program, "model", *self.words, "--threads", threads, "--quiet", "-o", model, "--report", report, *more],
                   self.limit)
        made = json.loads(report.read_text())
        done["size_mm"] = made["sizes"]["size_mm"]
        done["stages"] = {stage["name"]: stage["seconds"] for stage in made["timing"]["stages"]}
        done["stages"]["writing"] = max(0.0, done["seconds"] - sum(done["stages"].values()))
        done["model"] = model
        return done

    def cgal(self, variant="sequential", threads=1, slivers=False):
        model = self.folder / f"cgal-{variant}{'-slivers' if slivers else ''}.vtu"
        lengths = {"facet-radius": FACET_RADIUS, "cell-radius": CELL_RADIUS, "facet-distance": FACET_DISTANCE,
                   "surface-error": SURFACE_ERROR}
        done = run([self.build / f"bench/anatomesh_peers_{variant}", *self.words, "--threads", threads, "--model", model,
                    *(["--perturb-exude"] if slivers else []),
                    *(word for name, share in lengths.items() for word in (f"--{name}", f"{share * self.size:.9f}"))], self.limit)
        answer = json.loads(done["out"])
        # What writing took does not count.
        seconds = answer["seconds"]
        done.update(seconds=sum(seconds.values()), meshing=sum(seconds[stage] for stage in CGAL_MESHING), cpu=answer["cpu_seconds"],
                    mb=answer["peak_memory_mb"], model=model)
        return done

    def cgal_for_surface(self):
        done = self.cgal()
        if not (self.folder / "CGAL's.json").exists():
            self.write_surface("CGAL's", done["model"])
        return done

    def tetgen(self, whose):
        done = run(["tetgen", "-pq1.414YgAQ", self.folder / f"{whose}.poly"], self.limit)
        return {**done, "model": self.folder / f"{whose}.1.mesh", "references": "regions"}

    def gmsh(self, whose):
        """HXT, the fastest of Gmsh's volume meshers, and Gmsh's own optimiser, which is on by default."""
        model = self.folder / "gmsh.mesh"
        done = run(["gmsh", self.folder / f"{whose}.geo", "-3", "-clmax", f"{self.size:.9f}", "-format", "mesh", "-o", model,
                    "-nt", 1, "-v", 4], self.limit)
        times = [line for line in done["out"].splitlines() if "Done meshing 3D" in line]
        errors = [line for line in done["out"].splitlines() if "Error" in line]
        if errors or not times:
            raise Failure(errors[0].split(":", 1)[1].strip() if errors else "no volume mesh")
        wall, cpu = (float(times[-1].split(clock)[1].split("s")[0]) for clock in ("Wall", "CPU"))
        return {**done, "seconds": wall, "cpu": cpu, "model": model, "references": "pieces"}

    def netgen(self, whose):
        model = self.folder / "netgen.mesh"
        done = run([PYTHON, SOURCE / "bench/netgen_mesher.py", self.folder / f"{whose}.npz", model, self.size], self.limit)
        return {**done, **json.loads(done["out"].splitlines()[-1]), "model": model, "references": "regions"}

    def from_surface(self, mesher):
        """On the first surface that the mesher takes: CGAL's, else ours."""
        reasons = []
        for whose in ("CGAL's", "ours"):
            if not (self.folder / f"{whose}.json").exists():
                reasons.append(f"{whose}: no model")
                continue
            try:
                return {**mesher(whose), "surface": whose, "refused": "; ".join(reasons)}
            except Failure as failure:
                reasons.append(f"{whose}: {failure}")
        raise Failure("; ".join(reasons))

    def contenders(self):
        """Name -> function. The first one of CGAL gives those after it their surface."""
        every = {
            "anatomesh": self.ours,
            "anatomesh, 2 threads": lambda: self.ours(threads=2),
            "CGAL": self.cgal_for_surface,
            "CGAL, 2 threads": lambda: self.cgal(variant="parallel", threads=2),
            "CGAL + perturb + exude": lambda: self.cgal(slivers=True),
            "TetGen": lambda: self.from_surface(self.tetgen),
            "Gmsh HXT": lambda: self.from_surface(self.gmsh),
            "Netgen": lambda: self.from_surface(self.netgen),
        }
        return {name: self.judged(contender) for name, contender in every.items()}

    def judged(self, contender):
        """The contender; its first model is judged, and the figures stand beside what every run cost."""
        known = {}

        def judging():
            done = contender()
            if not known:
                note("    judging")
                surface = [self.folder / f"{done['surface']}.json", done["references"]] if "references" in done else []
                answer = run([PYTHON, SOURCE / "bench/measuring.py", done["model"], self.contours, *surface], JUDGE_LIMIT)
                known.update(json.loads(answer["out"]))
            return {**done, "figures": known}
        return judging
