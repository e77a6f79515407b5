"""report.html and the exports, from the command line; the report also in a headless Chromium."""
import csv
import json
import struct
import tempfile
import unittest

from browser import CHROMIUM, Browser
from cohort_e2e import ProgramTest, cohort

# What a page must not run or break at.
ODD_NAMES = [
    "<script>alert(1)<∕script>.ply", "<img src=x onerror=alert(2)>.ply",
    "a&b \"quoted\" 'single'.ply", "Žofie 顔.ply", "x" * 200 + ".ply",
    "very_long_study_name_2016_session_03_subject_0001_left.ply", "]]>--><b>.ply",
    "very_long_study_name_2016_session_03_subject_0002_left.ply",
]


def ply_vertices(data):
    """The x, y, z of a binary PLY of ours whose vertices have nothing else."""
    head, body = data.split(b"end_header\n", 1)
    count = int(head.split(b"element vertex ")[1].split()[0])
    return [struct.unpack_from("<3f", body, 12 * i) for i in range(count)]


class ReportTest(ProgramTest):
    def run_on(self, folder, name, *arguments):
        out = self.dir / name
        done = cohort("run", folder, "--out", out, *arguments)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        return out

    def odd_folder(self, count=8):
        """Meshes with names that are hard on a page, and one that is no mesh."""
        folder = self.dir / "odd"
        folder.mkdir()
        for name, scan in zip(ODD_NAMES[:count], sorted(self.demo.glob("*.ply"))):
            (folder / name).write_bytes(scan.read_bytes())
        (folder / "broken <b>.ply").write_text("ply\nno mesh <b>\n")
        return folder


class Report(ReportTest):
    def test_the_same_work_gives_the_same_report(self):
        labels = ("--labels", self.demo / "labels.csv")
        one = self.run_on(self.demo, "one", *labels, "--workers", 1, "--threads", 1)
        two = self.run_on(self.demo, "two", *labels, "--workers", 2, "--threads", 2)
        self.assertEqual((one / "report.html").read_bytes(), (two / "report.html").read_bytes())
        files = [file["name"] for file in json.loads((one / "job.json").read_text())["files"]]
        for name in ("report.html", "dendrogram.newick", "variation.vtk", "variation.png"):
            self.assertIn(name, files)
            self.assertTrue((one / name).is_file(), name)

    def test_no_report_leaves_it_out(self):
        out = self.run_on(self.demo, "out")
        self.assertTrue((out / "report.html").is_file())
        again = self.run_on(self.demo, "out", "--no-report")
        self.assertFalse((again / "report.html").exists())
        files = [file["name"] for file in json.loads((again / "job.json").read_text())["files"]]
        self.assertNotIn("report.html", files)

    def test_meshes_are_written_in_the_frame_of_the_job(self):
        address = "unix:" + str(self.dir / "s")
        self.start_server(address)
        self.start("cohort-worker", "--server", address, "--threads", 1)
        scans = sorted(self.demo.glob("*.ply"))[:3]
        added = cohort("add", *scans, "--set", "s", "--server", address)
        self.assertEqual(added.returncode, 0, added.stderr)
        done = cohort("submit", "--set", "s", "--wait", "--server", address)
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.dir / "out"
        for form in ("ply", "obj", "stl"):
            got = cohort("results", "j-000001", "--out", out, "--meshes", form, "--server", address)
            self.assertEqual(got.returncode, 0, got.stderr)
            names = sorted(file.name for file in (out / "aligned").glob("*." + form))
            self.assertEqual(names, [scan.stem + "." + form for scan in scans])
        files = [file["name"] for file in json.loads((out / "job.json").read_text())["files"]]
        self.assertIn("aligned/", files)
        # Centroids: x_reference = scale R x_file + t. The canonical mesh has another order of
        # vertices than the file, so single ones cannot be compared.
        with open(out / "transforms.csv", newline="") as file:
            rows = {row["file"]: row for row in csv.DictReader(file)}
        for scan in scans:
            row = rows[scan.name]
            before = ply_vertices(scan.read_bytes())
            after = ply_vertices((out / "aligned" / scan.name).read_bytes())
            self.assertEqual(len(before), len(after))
            middle = [sum(p[k] for p in before) / len(before) for k in range(3)]
            for k in range(3):
                expected = float(row["t" + "xyz"[k]]) + float(row["scale"]) * sum(
                    float(row[f"r{k + 1}{j + 1}"]) * middle[j] for j in range(3))
                self.assertAlmostEqual(sum(p[k] for p in after) / len(after), expected, delta=0.01)
        wrong = cohort("results", "j-000001", "--out", out, "--meshes", "vrml", "--server", address)
        self.assertNotEqual(wrong.returncode, 0)
        self.assertIn("--meshes vrml: expected ply, obj or stl", wrong.stderr)


@unittest.skipUnless(CHROMIUM, "chromium is not installed")
class Page(ReportTest):
    def setUp(self):
        super().setUp()
        self.browser = Browser(tempfile.mkdtemp(dir=self.dir))

    def tearDown(self):
        self.browser.close()
        super().tearDown()

    def open(self, out):
        self.browser.open((out / "report.html").as_uri())
        self.assert_quiet()

    def assert_quiet(self):
        self.browser.settle()
        self.assertEqual(self.browser.complaints(), [])
        self.assertEqual(self.browser.requests(), [])

    def sections(self):
        return self.browser.evaluate(
            "[...document.querySelectorAll('section')].map((section) => section.id)")

    def test_a_labelled_set_opens_without_errors_or_requests(self):
        out = self.run_on(self.demo, "out", "--labels", self.demo / "labels.csv")
        self.open(out)
        self.assertEqual(self.sections(), [
            "summary", "health", "matrix", "neighbours", "distribution", "identification",
            "dendrogram", "ordination", "shape", "registration", "parameters"])
        # Every picture is there, every picture has words.
        self.assertTrue(self.browser.evaluate(
            "[...document.images].every((image) => image.naturalWidth > 100 && image.alt)"))
        self.assertTrue(self.browser.evaluate(
            "[...document.querySelectorAll('svg, canvas, .thumb')]"
            ".every((one) => one.getAttribute('aria-label'))"))
        # Nothing sticks out of the page to the side.
        self.assertTrue(self.browser.evaluate(
            "document.documentElement.scrollWidth <= window.innerWidth"))

    def test_the_heat_map_is_drawn_sorted_and_tells_its_pairs(self):
        out = self.run_on(self.demo, "out", "--labels", self.demo / "labels.csv")
        self.open(out)
        with open(out / "matrix.csv", newline="") as file:
            rows = list(csv.reader(file))
        names, values = rows[0][1:], [[float(v) for v in row[1:]] for row in rows[1:]]

        def said_at(row, column):
            """What is said about a cell of the picture, as under the pointer."""
            return self.browser.evaluate(f"""(() => {{
              const canvas = document.getElementById("map");
              const frame = canvas.getBoundingClientRect();
              const scale = canvas.clientWidth / canvas.width;
              const cell = canvas.clientHeight / {len(names)};
              const left = canvas.clientWidth - canvas.clientHeight;
              canvas.dispatchEvent(new MouseEvent("mousemove", {{
                clientX: frame.left + left + cell * ({column} + 0.5),
                clientY: frame.top + cell * ({row} + 0.5)}}));
              return document.getElementById("map-said").innerText;
            }})()""").split("\n")

        def sort_by(order, mesh=0):
            self.browser.evaluate(f"""(() => {{
              document.getElementById("map-mesh").value = "{mesh}";
              const sort = document.getElementById("map-sort");
              sort.value = "{order}";
              sort.dispatchEvent(new Event("change"));
            }})()""")

        sort_by("name")
        said = said_at(2, 5)
        self.assertIn(names[2], said[0])
        self.assertIn(names[5], said[1])
        self.assertAlmostEqual(float(said[2].split()[0]), values[2][5], delta=1e-3)
        self.assertEqual(said_at(3, 3)[1], "the mesh itself")

        sort_by("mesh", 4)
        order = sorted(range(len(names)), key=lambda i: (-1 if i == 4 else values[i][4]))
        for place, mesh in enumerate(order):
            self.assertIn(names[mesh], said_at(place, 0)[0])

        sort_by("clusters")
        newick = (out / "dendrogram.newick").read_text()
        in_tree = sorted(names, key=newick.index)
        self.assertEqual([said_at(i, 0)[0].split(" ")[0] for i in range(len(names))], in_tree)

        sort_by("person")
        self.assertEqual(len({said_at(i, 0)[0].split("(")[1] for i in (0, 1)}), 1)

        self.assert_quiet()

        # The nearest pair is dark, the farthest one bright.
        sort_by("name")
        pairs = [(values[i][j], i, j) for i in range(len(names)) for j in range(i)]
        shades = [self.browser.evaluate(f"""(() => {{
          const canvas = document.getElementById("map");
          const side = canvas.height / {len(names)};
          const left = canvas.width - canvas.height;
          const data = canvas.getContext("2d").getImageData(
              left + side * ({j} + 0.5), side * ({i} + 0.5), 1, 1).data;
          return data[0] + data[1] + data[2];
        }})()""") for _, i, j in (min(pairs), max(pairs))]
        self.assertLess(shades[0], 200)
        self.assertGreater(shades[1], 400)

    def test_the_heat_map_is_walked_by_keys(self):
        out = self.run_on(self.demo, "out")
        self.open(out)
        # The first key comes to the first cell; then row 2, column 1.
        for key in ("ArrowDown", "ArrowDown", "ArrowDown", "ArrowRight"):
            self.browser.evaluate(
                f"document.getElementById('map').dispatchEvent("
                f"new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))")
        said = self.browser.evaluate("document.getElementById('map-said').innerText")
        self.assertIn("mm", said)
        self.assert_quiet()

    def test_odd_names_do_no_harm(self):
        out = self.run_on(self.odd_folder(), "out")
        self.open(out)
        self.assertEqual(self.browser.evaluate("document.scripts.length"), 2)
        text = self.browser.evaluate("document.body.textContent")
        for name in ODD_NAMES + ["broken <b>.ply"]:
            self.assertIn(name, text)
        self.assertEqual(self.browser.evaluate("document.querySelectorAll('b').length"), 0)
        self.assertTrue(self.browser.evaluate(
            "document.documentElement.scrollWidth <= window.innerWidth"))
        self.assertNotIn("identification", self.sections())

    def test_two_meshes_are_enough(self):
        out = self.run_on(self.odd_folder(count=2), "out")
        self.open(out)
        self.assertNotIn("ordination", self.sections())

    def test_signed_distances_of_the_predecessor(self):
        out = self.run_on(self.demo, "out", "--preset", "fidentis", "--signed")
        self.open(out)
        self.assertFalse((out / "dendrogram.newick").exists())
        self.assertIn("shape", self.sections())

    def test_it_prints(self):
        out = self.run_on(self.demo, "out")
        self.open(out)
        pdf = self.dir / "report.pdf"
        self.browser.pdf(pdf)
        self.assertEqual(pdf.read_bytes()[:5], b"%PDF-")
        self.assert_quiet()


if __name__ == "__main__":
    unittest.main()
