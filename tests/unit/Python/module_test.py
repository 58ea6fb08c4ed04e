#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""The Python module against closed forms, brute force in NumPy, and the ist command."""
import functools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import bullethaptics as bh
import numpy as np

IST = os.environ["IST"]
rng = np.random.default_rng(7)


def box(size, centre=(0, 0, 0)):
    corners = np.array([[x, y, z] for x in (-.5, .5) for y in (-.5, .5) for z in (-.5, .5)]) * size + centre
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def random_quaternion():
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


@functools.cache
def packed_box():
    return bh.build(*box((.2, .1, .06), centre=(3, 4, 5)), spheres=3000)


class Shared(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.box = packed_box()

    def poses(self, n):
        """Of the box in itself, near enough to overlap, as PyBullet's pairs."""
        centre = np.array([3, 4, 5.])
        for _ in range(n):
            q = random_quaternion()
            yield centre + rng.uniform(-.04, .04, 3) - rotation(q) @ centre, q

    def force_errors(self, answer, full):
        """Of each row, as shares of the force, or of that at 0.1 % overlap where it is less."""
        floor = .001 * self.box.volume  # k = 1
        return np.linalg.norm(answer["force"] - full["force"], axis=1) / np.maximum(np.linalg.norm(full["force"], axis=1), floor)


class Build(Shared):
    def test_mass_properties_are_those_of_a_box(self):
        a, b, c = .2, .1, .06
        self.assertAlmostEqual(self.box.volume, a * b * c, delta=1e-12)
        np.testing.assert_allclose(self.box.center_of_mass, (3, 4, 5), atol=1e-12)
        np.testing.assert_allclose(self.box.inertia, a * b * c / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b]), atol=1e-15)

    def test_spheres_are_a_packing_in_the_box(self):
        s = self.box.spheres.astype(float)
        self.assertEqual(s.shape, (3000, 4))
        self.assertTrue((np.abs(s[:, :3]) + s[:, 3:] <= np.array([.1, .05, .03]) + 1e-9).all())
        distance = np.linalg.norm(s[:, None, :3] - s[None, :, :3], axis=2) - s[:, None, 3] - s[None, :, 3]
        np.fill_diagonal(distance, np.inf)
        self.assertGreaterEqual(distance.min(), -1e-12)
        self.assertAlmostEqual(self.box.fill, (4 / 3 * np.pi * s[:, 3] ** 3).sum() / self.box.volume, delta=1e-6)

    def test_spheres_cannot_be_written_and_outlive_the_tree(self):
        tree = bh.build(*box((1, 1, 1)), spheres=50)
        spheres, first = tree.spheres, tree.spheres[0].copy()
        with self.assertRaises(ValueError):
            spheres[0, 0] = 1
        del tree
        np.testing.assert_array_equal(spheres[0], first)

    def test_flat_lists_and_soups_are_the_same_mesh(self):
        vertices, triangles = box((1, 1, 1))
        trees = [bh.build(vertices, triangles, spheres=100), bh.build(vertices.ravel().tolist(), triangles.ravel().tolist(), spheres=100),
                 bh.build(vertices[triangles].reshape(-1, 3), spheres=100)]
        for tree in trees[1:]:
            self.assertAlmostEqual(tree.volume, trees[0].volume, delta=1e-12)
            self.assertAlmostEqual(tree.fill, trees[0].fill, delta=.02)
        np.testing.assert_array_equal(trees[0].spheres, trees[1].spheres)

    def test_files_keep_everything(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "box.ist")
            self.assertEqual(self.box.save(path), os.path.getsize(path))
            info = json.loads(subprocess.run([IST, "info", path, "--json"], check=True, capture_output=True, text=True).stdout)
            self.assertEqual(self.box.leaves, info["leaves"])
            self.assertEqual(self.box.elements, info["surface_elements"])
            self.assertEqual(self.box.sagitta, info["sagitta"])
            self.assertEqual(repr(self.box), f"<bullethaptics.Tree of {info['spheres']} spheres, {info['leaves']} leaves>")
            loaded = bh.load(path)
            np.testing.assert_array_equal(loaded.spheres, self.box.spheres)
            by_path = pathlib.Path(folder, "path.ist")
            self.assertEqual(loaded.save(by_path), by_path.stat().st_size)
            np.testing.assert_array_equal(bh.load(by_path).spheres, self.box.spheres)
            X = (3.15, 4.02, 5.01, 0, 0, 0, 1)
            self.assertEqual(bh.query(loaded, self.box, X)["volume"], bh.query(self.box, self.box, X)["volume"])

    def test_read_mesh_gives_what_the_file_holds(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "t.obj")
            path.write_text("v 0 0 0\nv 1000 0 0\nv 0 2000 0\nf 1 2 3\n")
            vertices, triangles = bh.read_mesh(str(path), unit=.001)
            np.testing.assert_array_equal(bh.read_mesh(path, unit=.001)[0], vertices)
        np.testing.assert_allclose(vertices[triangles[0]], [[0, 0, 0], [1, 0, 0], [0, 2, 0]])

    def test_read_mesh_applies_the_unit_that_the_file_states(self):
        corners = "".join(f"<vertex><coordinates><x>{x}</x><y>{y}</y><z>0</z></coordinates></vertex>" for x, y in ((0, 0), (1, 0), (0, 2)))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "t.amf")
            path.write_text(f'<amf unit="inch"><object id="0"><mesh><vertices>{corners}</vertices>'
                            "<volume><triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle>"
                            "</volume></mesh></object></amf>")
            vertices, triangles = bh.read_mesh(path)
            np.testing.assert_allclose(vertices[triangles[0]], [[0, 0, 0], [.0254, 0, 0], [0, .0508, 0]])
            warning = 't.amf: The file states "inch" as its unit, 0.0254 m; in its place the given unit was applied, 1 m.'
            with self.assertWarnsRegex(UserWarning, warning):
                np.testing.assert_allclose(bh.read_mesh(path, unit=1)[0][triangles[0]], [[0, 0, 0], [1, 0, 0], [0, 2, 0]])

    def test_read_mesh_warns_of_what_it_could_not_take(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "t.obj")
            path.write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\nl 1 2\n")
            with self.assertWarnsRegex(UserWarning, "t.obj: 1 line was left out"):
                bh.read_mesh(str(path))
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.assertRaises(UserWarning, bh.read_mesh, str(path))


class Query(Shared):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.levelled = bh.with_levels(cls.box)
        cls.leaves = bh.build(*box((.2, .1, .06), centre=(3, 4, 5)), spheres=3000, surface=False)
        cls.levelled_leaves = bh.with_levels(cls.leaves)

    def test_volume_and_force_of_slabs(self):
        depth = .02  # on the faces of .1 x .06: V = A depth; at depth s the face is the nearest side on (.1 - 2 s) (.06 - 2 s)
        facing = .1 * .06 * depth - (.1 + .06) * depth ** 2 + 4 / 3 * depth ** 3
        r = bh.query(self.box, self.box, (.2 - depth, 0, 0, 0, 0, 0, 1), stiffness=1e6)
        volume = .1 * .06 * depth
        self.assertAlmostEqual(r["volume"], volume, delta=.02 * volume)
        np.testing.assert_allclose(r["force"], [-1e6 * facing, 0, 0], atol=.02 * 1e6 * facing)
        np.testing.assert_allclose(r["centroid"], [3 + .1 - depth / 2, 4, 5], atol=.002)
        np.testing.assert_allclose(r["normal"], [-1, 0, 0], atol=.07)  # 4 degrees

    def test_contact_surface_adds_up_to_the_force(self):
        X = (.19, .01, .02, 0, 0, 0, 1)
        points, whole = bh.contact_surface(self.box, self.box, X, stiffness=1e6), bh.query(self.box, self.box, X, stiffness=1e6)
        forces = points["normal"] * (points["area"] * points["pressure"])[:, None]
        size = np.linalg.norm(forces, axis=1).sum()
        np.testing.assert_allclose(forces.sum(axis=0), whole["force"], atol=1e-5 * size)
        self.assertGreater(len(points["area"]), 10)
        self.assertTrue(points["of_a"].any() and not points["of_a"].all())
        self.assertEqual(len(bh.contact_surface(self.box, self.box, (5, 0, 0, 0, 0, 0, 1))["area"]), 0)
        self.assertEqual(len(bh.contact_surface(self.leaves, self.leaves, X)["area"]), 0)

    def test_every_shape_of_poses_says_the_same(self):
        pairs = list(self.poses(5))
        sevens = np.array([np.concatenate(p) for p in pairs])
        matrices = np.array([np.block([[rotation(q), t[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]) for t, q in pairs])
        rows, fours = bh.query(self.box, self.box, sevens), bh.query(self.box, self.box, matrices)
        self.assertEqual(rows["stiffness"].shape, (5, 6, 6))
        for i, (t, q) in enumerate(pairs):
            one = bh.query(self.box, self.box, (tuple(t), tuple(q)))
            self.assertGreater(one["volume"], 0)
            for name, value in one.items():
                np.testing.assert_allclose(rows[name][i], value, rtol=1e-12, err_msg=name)
                np.testing.assert_allclose(fours[name][i], value, rtol=1e-6, atol=1e-9, err_msg=name)

    def test_rows_are_those_of_the_command(self):
        sevens = np.array([np.concatenate(p) for p in self.poses(4)] + [[9, 0, 0, 0, 0, 0, 1]])
        with tempfile.TemporaryDirectory() as folder:
            asset, poses = os.path.join(folder, "box.ist"), os.path.join(folder, "poses.csv")
            self.box.save(asset)
            np.savetxt(poses, sevens, delimiter=",", header="tx,ty,tz,qx,qy,qz,qw", comments="", fmt="%.17g")
            for options, named in (([], {}), (["--error", ".2"], {"error": .2}), (["--level", "3"], {"level": 3})):
                out = subprocess.run([IST, "query", asset, asset, "--poses", poses, "--stiffness", "1e5", "--json", *options],
                                     check=True, capture_output=True, text=True)
                ours = bh.query(self.levelled, self.levelled, sevens, stiffness=1e5, **named)
                self.assertEqual({"promise", "kept"} <= set(ours), "error" in named)
                for line in out.stdout.splitlines():
                    row = json.loads(line)
                    for name, column in ours.items():
                        theirs = np.array(np.nan if row[name] is None else row[name], dtype=float)
                        mine = column[row["row"]].ravel().astype(float)
                        np.testing.assert_allclose(mine, np.broadcast_to(theirs, mine.size), rtol=1e-9, atol=1e-15, err_msg=name)

    def test_distance_of_boxes(self):
        upper, lower = bh.distance(self.box, self.box, np.array([[.3, 0, 0, 0, 0, 0, 1], [.25, 0, 0, 0, 0, 0, 1]]))
        for gap, u, l in zip((.1, .05), upper, lower):
            self.assertLessEqual(l, gap)
            self.assertGreaterEqual(u, gap)
            self.assertLess(u - gap, .01)

    def test_relative_pose_takes_points_of_b_to_a(self):
        for _ in range(20):
            (ta, qa), (tb, qb) = ((rng.normal(size=3) * 10, random_quaternion()) for _ in range(2))
            X = bh.relative_pose((tuple(ta), tuple(qa)), (tuple(tb), tuple(qb)))
            p = rng.normal(size=3)
            np.testing.assert_allclose(rotation(qa) @ (rotation(X[3:]) @ p + X[:3]) + ta, rotation(qb) @ p + tb, atol=1e-12)

    def test_levels_keep_the_budget(self):
        tree = self.levelled_leaves
        X = (.1, .01, .005, 0, 0, 0, 1)
        full = bh.query(tree, tree, X)
        coarse = bh.query(tree, tree, X, max_pairs=int(full["pairs"]) // 4)
        self.assertLessEqual(coarse["pairs"], full["pairs"] // 4)
        self.assertGreater(coarse["level"], 0)
        self.assertAlmostEqual(coarse["volume"], full["volume"], delta=.05 * full["volume"])


    def test_an_accepted_error_costs_less_and_holds(self):
        poses = np.array([np.concatenate(p) for p in self.poses(100)])
        full = bh.query(self.levelled_leaves, self.levelled_leaves, poses)
        for error in (.1, .3):
            answer = bh.query(self.levelled_leaves, self.levelled_leaves, poses, error=error)
            np.testing.assert_array_equal(answer["kept"], answer["promise"] <= error)
            self.assertGreater(answer["kept"].mean(), .9)
            self.assertGreaterEqual((self.force_errors(answer, full) <= answer["promise"]).mean(), .9)  # 95 % is what is promised
            self.assertLess(answer["pairs"].sum(), full["pairs"].sum() * (.5 if error == .1 else .1))

    def test_an_error_out_of_reach_is_answered_in_full(self):
        poses = np.array([np.concatenate(p) for p in self.poses(5)])
        full, answer = bh.query(self.levelled, self.levelled, poses), bh.query(self.levelled, self.levelled, poses, error=1e-6)
        self.assertFalse(answer["kept"].any())
        for name, column in full.items():
            np.testing.assert_array_equal(answer[name], column, err_msg=name)


class Tune(Shared):
    def command(self, a, b, *options):
        out = subprocess.run([IST, "tune", a, b, "--json", *options], capture_output=True, text=True)
        self.assertLessEqual(out.returncode, 1, out.stderr)
        answer = json.loads(out.stdout)
        self.assertEqual(answer.pop("schema"), 1)
        return answer

    def same(self, ours, theirs):
        """But for times, and what is chosen by them."""
        self.assertEqual(list(ours), list(theirs))
        for chosen in (ours, theirs):
            best = {name: chosen[name] for name in chosen["alternatives"][0]}
            self.assertIn(best, chosen["alternatives"])
            for a in [chosen, *chosen["alternatives"]]:
                self.assertGreater(a.pop("time_us"), 0)
            for name in best.keys() - {"time_us"}:
                chosen.pop(name)
        self.assertEqual(ours, theirs)

    def test_it_answers_what_the_command_answers(self):
        with tempfile.TemporaryDirectory() as folder:
            asset, mesh = os.path.join(folder, "box.ist"), os.path.join(folder, "cube.obj")
            self.box.save(asset)
            for error, options, world in ((.2, [], {}), (.0001, ["--stiffness", "1e5", "--mass", "2"], {"stiffness": 1e5, "mass": 2}),
                                          (.5, ["--stiffness", "1e6", "--mass", "2", "--speed", "3", "--step", ".02", "--distance", "1e6"],
                                           {"stiffness": 1e6, "mass": 2, "speed": 3, "step": .02, "distance": 1e6})):
                self.same(bh.tune(self.box, self.box, error, **world), self.command(asset, asset, "--error", str(error), *options))
            cube = box((1, 1, 1))
            with open(mesh, "w") as file:
                file.writelines(f"v {x} {y} {z}\n" for x, y, z in cube[0])
                file.writelines(f"f {a} {b} {c}\n" for a, b, c in cube[1] + 1)
            self.same(bh.tune(cube, cube, .25, max_spheres=30), self.command(mesh, mesh, "--error", ".25", "--max-spheres", "30"))

    def test_it_is_the_cheapest_level_that_keeps_the_error(self):
        answer = bh.tune(self.box, self.box, .3)
        fixed = [a for a in answer["alternatives"] if a["level"] != "by pose"]
        self.assertEqual([a["level"] for a in fixed], list(range(len(fixed))))
        self.assertTrue(answer["kept"])
        self.assertEqual(answer["time_us"], min(a["time_us"] for a in fixed if a["error"] <= .3))
        self.assertEqual((answer["spheres"], answer["spheres_a"], answer["spheres_b"]), (3000, 3000, 3000))

        tree = bh.with_levels(self.box)
        poses = np.array([np.concatenate(p) for p in self.poses(100)])
        errors = self.force_errors(bh.query(tree, tree, poses, level=answer["level"]), bh.query(tree, tree, poses))
        self.assertGreaterEqual((errors <= answer["error"]).mean(), .9)

    def test_out_of_reach_is_an_answer(self):
        answer = bh.tune(self.box, self.box, .0001)
        self.assertIs(answer["kept"], False)
        self.assertEqual(answer["error"], min(a["error"] for a in answer["alternatives"]))

    def test_a_mesh_gets_trees(self):
        stages = []
        answer = bh.tune(box((1, 1, 1)), self.box, .0001, max_spheres=30, progress=lambda stage, fraction: stages.append((stage, fraction)))
        self.assertEqual((answer["spheres_a"], answer["spheres_b"], answer["kept"]), (30, 3000, False))
        self.assertTrue({"packing", "tune"} <= {stage for stage, _ in stages})
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in stages))

    def test_a_world_follows_closed_forms(self):
        answer = bh.tune(self.box, self.box, .5, stiffness=1e6, mass=2, speed=3, step=.05)
        self.assertAlmostEqual(answer["rest_depth_m"] * answer["frequency_rad_s"] ** 2, 9.81, delta=1e-9)
        self.assertAlmostEqual(answer["explicit_step_s"] * answer["frequency_rad_s"], 2, delta=1e-9)
        thickness = 2 * self.box.volume / self.box.area
        self.assertAlmostEqual(answer["thickness_step_s"] * 3, thickness / 4, delta=1e-9)
        self.assertEqual(answer["substeps"], np.ceil(.05 / min(answer["thickness_step_s"], answer["restitution_step_s"])))
        self.assertEqual(answer["precision"], "float")
        far = bh.tune(self.box, self.box, .5, stiffness=1e6, mass=2, distance=1e6)
        self.assertEqual(far["precision"], "double")  # a float that is a million has its neighbour at a sixteenth
        self.assertIsNone(far["thickness_step_s"])


class Refusals(Shared):
    def refused(self, error, words, call, *arguments, **named):
        with self.assertRaises(error) as caught:
            call(*arguments, **named)
        self.assertIn(words, str(caught.exception))

    def test_meshes(self):
        vertices, triangles = box((1, 1, 1))
        self.refused(ValueError, "vertex 8", bh.build, vertices, triangles + 1)
        self.refused(ValueError, "vertex -1", bh.build, vertices, triangles - 1)
        self.refused(ValueError, "whole numbers", bh.build, vertices, triangles * .5)
        self.refused(ValueError, "shape (n, 3)", bh.build, vertices[:, :2], triangles)
        self.refused(ValueError, "each three vertices", bh.build, vertices)
        self.refused(ValueError, "repair", bh.build, vertices, triangles, repair="maybe")
        for text in ("ground", "ground 0", "ground 1 w"):
            self.refused(ValueError, "depth", bh.build, vertices, triangles, repair=text)
        self.refused(ValueError, "spheres", bh.build, vertices, triangles, spheres=0)
        self.refused(bh.Error, "", bh.build, np.zeros((0, 3)), np.zeros((0, 3), int))
        self.refused(bh.Error, "", bh.build, np.where(vertices > .4, np.nan, vertices), triangles)
        self.refused(bh.Error, "nowhere.ist", bh.load, "nowhere.ist")

    def test_units_and_axes_of_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "point.obj"
            path.write_text("v 1 2 3\nv 4 5 7\nv 0 1 0\nf 1 2 3\n")
            plain = bh.read_mesh(path)[0]
            for unit, metres in (("mm", .001), ("in", .0254), ("0.5", .5), (.25, .25), (2, 2)):
                np.testing.assert_allclose(bh.read_mesh(path, unit=unit)[0], plain * metres, rtol=1e-12)
            np.testing.assert_array_equal(bh.read_mesh(path, up="z")[0], plain[:, [0, 2, 1]] * (1, 1, -1))
            np.testing.assert_array_equal(bh.read_mesh(path, up="y,x")[0], plain[:, [1, 0, 2]] * (1, -1, 1))
            self.refused(ValueError, "unit must be metres, or", bh.read_mesh, path, unit="miles")
            self.refused(ValueError, "up must be an axis", bh.read_mesh, path, up="up")

    def test_open_ground(self):
        """A square of four triangles about a hill, closed 0.5 m deep: the prism and the pyramid."""
        corners = np.array([[0, 0, 0], [2, 0, 0], [2, 0, 2], [0, 0, 2], [1, .3, 1]])
        hill = np.array([(0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)])
        self.refused(bh.Error, "ground that faces y", bh.build, corners * (1, 0, 1), hill, spheres=50)
        tree = bh.build(corners, hill, spheres=50, repair="ground 0.5 y")
        self.assertAlmostEqual(tree.volume, 4 * .5 + 4 * .3 / 3, 9)
        self.assertTrue(any("Closed the surface downwards" in sentence for sentence in tree.repair))

    def test_poses(self):
        def ask(pose):
            return bh.query(self.box, self.box, pose)
        self.refused(ValueError, "quaternion has length", ask, (0, 0, 0, 0, 0, 0, 2))
        self.refused(ValueError, "pose 1", ask, [[0, 0, 0, 0, 0, 0, 1], [np.nan, 0, 0, 0, 0, 0, 1]])
        self.refused(ValueError, "not a rigid", ask, 2 * np.eye(4))
        self.refused(ValueError, "not a rigid", ask, np.diag([-1., 1, 1, 1]))
        self.refused(ValueError, "shape (7)", ask, (1, 2, 3))
        self.refused(ValueError, "a pose is", ask, "here")
        self.refused(ValueError, "stiffness", bh.query, self.box, self.box, (0, 0, 0, 0, 0, 0, 1), stiffness=-1)
        self.refused(ValueError, "level", bh.query, self.box, self.box, (0, 0, 0, 0, 0, 0, 1), level=3)
        self.refused(ValueError, "level", bh.query, self.box, self.box, (0, 0, 0, 0, 0, 0, 1), level=-2)
        self.refused(ValueError, "max_pairs", bh.query, self.box, self.box, (0, 0, 0, 0, 0, 0, 1), max_pairs=-2)

    def test_accepted_errors(self):
        def ask(error):
            return bh.query(self.box, self.box, (0, 0, 0, 0, 0, 0, 1), error=error)
        self.refused(ValueError, "with_levels()", ask, .1)
        for error in (0, -1, 1.5, np.nan, np.inf):
            self.refused(ValueError, "error must be above 0", ask, error)
            self.refused(ValueError, "error must be above 0", bh.tune, self.box, self.box, error)

    def test_tunings(self):
        def tune(a=self.box, b=self.box, **named):
            return bh.tune(a, b, .5, **named)
        self.refused(ValueError, "a must be a Tree, or a mesh", tune, a="box.ist")
        self.refused(ValueError, "b must be a Tree, or a mesh", tune, b=None)
        self.refused(ValueError, "b must be a Tree, or a mesh", tune, b=np.zeros((2, 3)))
        self.refused(ValueError, "a: vertices must be", tune, a=("here", None))
        self.refused(ValueError, "vertex 8", tune, a=(box((1, 1, 1))[0], box((1, 1, 1))[1] + 1))
        self.refused(bh.Error, "b: ", tune, b=([], []))
        self.refused(ValueError, "max_spheres", tune, max_spheres=0)
        for name in ("stiffness", "mass"):
            self.refused(ValueError, "both a stiffness and a mass", tune, **{name: 1})
        for name in ("speed", "step", "distance"):
            self.refused(ValueError, "both a stiffness and a mass", tune, **{name: .5})
        wrong = {"stiffness": (0, -1, np.nan), "mass": (0, np.inf), "speed": (-1, np.nan), "step": (0, np.inf), "distance": (-1, np.inf)}
        for name, values in wrong.items():
            for value in values:
                self.refused(ValueError, f"{name} must be", tune, **{**{"stiffness": 1e5, "mass": 1}, name: value})
        self.refused(bh.Error, "cancelled", tune, progress=lambda stage, fraction: False)

        def fail(stage, fraction):
            raise KeyError("mine")
        self.refused(KeyError, "mine", tune, progress=fail)

    def test_progress_can_cancel_and_raise(self):
        stages = []
        bh.build(*box((1, 1, 1)), spheres=100, progress=lambda stage, fraction: stages.append(stage))
        self.assertIn("packing", stages)
        self.assertEqual(len(bh.build(*box((1, 1, 1)), spheres=100, progress=lambda stage, fraction: [1]).spheres), 100)
        self.refused(bh.Error, "cancel", bh.build, *box((1, 1, 1)), spheres=100, progress=lambda stage, fraction: [])
        self.refused(bh.Error, "cancel", bh.build, *box((1, 1, 1)), spheres=100, progress=lambda stage, fraction: False)

        def fail(stage, fraction):
            raise KeyError("mine")
        self.refused(KeyError, "mine", bh.build, *box((1, 1, 1)), spheres=100, progress=fail)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
