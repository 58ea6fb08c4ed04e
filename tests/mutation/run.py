#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Does a test fail when the code is wrong? Builds a copy of the source tree once as it is and once for each mutation below, and
demands that the named tests pass in the first and that one of them fails in each of the others.

Usage: run.py SOURCE [--only NAME] [--check] [--quick PROGRAM=EXCLUDED...] [-- options for cmake]
  --check: whether each mutation still finds the text that it replaces, and no more.
  --quick: how many mutations the tests of ./test.sh notice: those whose named tests it runs, all of them. It runs the given programs, each
    without the tests of the filter EXCLUDED, and it must notice nine tenths.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

CORE, COLLISION, BRIDGE = "BulletISTCollision/Core/", "BulletISTCollision/", "DeviceBridge/"

# Name: (file, text that occurs in it once, what takes its place, test program, tests of which one must fail).
MUTATIONS = {
    "density of leaves dropped": (
        CORE + "Geometry/MomentEllipsoid.cpp", "e.density = float(volume / (kUnitBall * double(e.R) * e.R * e.R));", "e.density = 1;",
        "test_core", "Cells.OfEqualSpheresInABoxAreVoronoiCells"),
    "density dropped from the sums": (
        CORE + "Query/Kernels/PairIntegrals.h", "density = a.density * b.density;", "density = F::all(1);",
        "test_core", "OverlapQuery.AgreesWithBruteForce*"),
    "density dropped from the sums of a half-space": (
        CORE + "Query/FieldClipper.cpp", "term.volume = leaf.density * cap.volume;", "term.volume = cap.volume;",
        "test_core", "HalfSpace.ManyBallsAgreeWithADirectSum"),
    "mean normal of leaves normalised": (
        CORE + "Leaves/CellSplitter.cpp", "e.setNormal(piece.normal);", "e.setNormal(normalized(piece.normal));",
        "test_core", "Cells.OneBallInASphereIsSplitIntoLeavesThatPointOutwards"),
    "mean normal normalised in the sums": (
        CORE + "Query/Kernels/PairIntegrals.h", "		l.mA = {a.normal.x, a.normal.y, a.normal.z};",
        "		const F m = F::squareRoot(a.normal.x * a.normal.x + a.normal.y * a.normal.y + a.normal.z * a.normal.z);\n"
        "		l.mA = {a.normal.x / m, a.normal.y / m, a.normal.z / m};",
        "test_core", "OverlapQuery.AgreesWithBruteForce*"),
    "splitting skipped": (
        CORE + "Leaves/CellSplitter.cpp", "while (pieces.size() < leafCount && !queue.empty())", "while (false)",
        "test_core", "Cells.OneBallInASphereIsSplitIntoLeavesThatPointOutwards"),
    "shape of leaves dropped": (
        CORE + "Leaves/CellSplitter.cpp", "momentEllipsoid(piece.centroid, piece.shape, piece.mass)",
        "momentEllipsoid(piece.centroid, SymmetricMatrix3::identity(piece.shape.trace() / 3), piece.mass)",
        "test_core", "Cells.*"),
    "shape of B not turned": (
        CORE + "Query/Kernels/PairSearch.h", "const F6 shape = turned(s.R, b.shape);", "const F6 shape = b.shape;",
        "test_core", "OverlapQuery.AgreesWithBruteForce*"),
    "shape dropped from a half-space": (
        CORE + "Geometry/Lens.h", "const Vec3 conjugate = e.shape() * normal;", "const Vec3 conjugate = normal * (e.shape().trace() / 3);",
        "test_core", "HalfSpace.*"),
    "normal of a lens flipped": (
        CORE + "Geometry/Lens.h", "lens.normal = offset * inverse;", "lens.normal = offset * -inverse;",
        "test_core", "Lens.*"),
    "normal of a half-space flipped": (
        CORE + "Query/FieldQuery.cpp", "sums.normalB.force += nB;", "sums.normalB.force -= nB;",
        "test_core", "HalfSpace.OneBallHasTheClosedForm"),
    "remembered pairs outlive their margin": (
        CORE + "Query/VerletList.cpp", "return valid = valid && m_filled.motionTo(now.X) <= m_margin;", "return valid;",
        "test_core", "VerletList.*"),
    "a turn uses up no margin": (
        CORE + "Query/VerletList.cpp", " + (std::sqrt(0.5 * squared) + skew) * reach;", ";",
        "test_core", "VerletList.*"),
    "remembered patches are never grouped anew": (
        CORE + "Query/VerletList.cpp", "return asMany && now.aligned", "return asMany || !asMany || now.aligned",
        "test_core", "VerletList.*"),
    "clearance without the radius of one ball": (
        CORE + "Query/LeafClearance.cpp", "return distance(a.center, b.center) - a.r - b.r - kRounding",
        "return distance(a.center, b.center) - a.r - kRounding",
        "test_core", "LeafClearance.*"),
    "bodies that came near stay apart": (
        COLLISION + "Contact/btISTContactCache.cpp", "return way < m_clearance;", "return true;",
        "test_collision", "btISTContactCache.*"),
    "kept beyond what is granted": (
        COLLISION + "Contact/btISTContactCache.cpp", "return used <= 1;", "return true;",
        "test_collision", "btISTContactCache.*"),
    "kept answers do not follow the motion": (
        COLLISION + "Contact/btISTContactCache.cpp", "	ist::moveB(contact.total, motion);\n", "",
        "test_collision", "btISTContactCache.*"),
    "normal of Bullet's plane flipped": (
        COLLISION + "Registry/btISTShapeField.cpp", "toVec3(plane->getPlaneNormal())", "toVec3(-plane->getPlaneNormal())",
        "test_collision", "btISTCollisionAlgorithm.BoxRestsOnAPlaneWithTheStockSolverInBothOrders"),
    "normal of Bullet's points flipped": (
        COLLISION + "Contact/btISTRepresentativePoints.cpp", "toBullet(p.normal), btScalar(-depth)",
        "toBullet(-p.normal), btScalar(-depth)",
        "test_collision", "btISTRegistration.AnswersThroughBothDispatchTables"),
    "table of closest points not registered": (
        COLLISION + "Dispatch/btISTInstallation.cpp", "if (entry == &ours) return;", "if (entry == &ours || closest) return;",
        "test_collision", "btISTRegistration.AnswersThroughBothDispatchTables"),
    "table of contacts not registered": (
        COLLISION + "Dispatch/btISTInstallation.cpp", "if (entry == &ours) return;", "if (entry == &ours || !closest) return;",
        "test_collision", "btISTRegistration.AnswersThroughBothDispatchTables"),
    "what is not finite passes": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "if (!finite)", "if (false)",
        "test_devices", "Safety*"),
    "old commands count in full": (
        BRIDGE + "Safety/AgeFade.h", "if (age < 0 || age >= zeroFrom || now >= command.expiresAt) return 0;", "if (age != -1) return 1;",
        "test_devices", "Safety*"),
    "a handle that nobody holds is pushed": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "if (m_enabled && (hand.flags & kReady) == kReady) return true;",
        "if (m_enabled) return true;",
        "test_devices", "Safety*"),
    "no ramp after enabling": (
        BRIDGE + "Safety/GainRamp.h", "return age >= m_duration ? 1", "return age >= 0 ? 1",
        "test_devices", "Safety*"),
    "force inside when enabled": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "m_inside.holds(inContact) && m_settings.startInsideLatch",
        "m_inside.holds(inContact) && false",
        "test_devices", "Safety*"),
    "torque without motors for it": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "if ((m_info.actuated >> axis & 1U) || value == 0) continue;", "if (axis >= 0) continue;",
        "test_devices", "Safety*"),
    "no passivity controller": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "if (m_settings.passivity && m_passivity", "if (false && m_passivity",
        "test_devices", "PassivityController.*"),
    "no slew limit": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "limitSlew(wrench.force, m_last.force, share * m_info.peakForce)", "false",
        "test_devices", "Safety*"),
    "no saturation": (
        BRIDGE + "Safety/SafetyLimiter.cpp",
        "if (saturate(wrench, m_info.peakForce, m_info.peakTorque, m_settings.oneFactor)) increment(m_saturated);", "",
        "test_devices", "Safety*"),
    "no continuous budget": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "m_forceHeat.limit(wrench.force)", "false",
        "test_devices", "Safety*"),
    "no brake above the largest speed": (
        BRIDGE + "Safety/SafetyLimiter.cpp", "if (m_brake.apply(out.wrench, hand.twist)) increment(m_overSpeed);", "",
        "test_devices", "Safety*"),
    "gap between ticks not bridged": (
        BRIDGE + "Loop/GapBridge.h", "if (dt > kShortest * period && m_hasLast)", "if (false)",
        "test_devices", "GapBridge.*"),
    "impulses of the hand taken twice": (
        BRIDGE + "Loop/WorldMirror.cpp", "		body.seen = now;\n", "",
        "test_devices", "WorldMirror.*"),
    "late world counts in full": (
        BRIDGE + "Loop/ModelAge.h", "if (late <= fullUntil) return 1;", "if (late >= 0) return 1;",
        "test_devices", "ModelAge.*"),
    "copies feel half of the tool": (
        BRIDGE + "Bullet/BulletLocalWorld.cpp", "const ist::Wrench onBody = -1.0 * impulse;",
        "const ist::Wrench onBody = -0.5 * impulse;",
        "test_bridge", "BulletDecoupled.ImpulsesBalance*"),
    "copies that nothing carries": (
        BRIDGE + "Bullet/BulletLocalWorld.cpp", "i < world.contactCount && !m_held; ++i)", "i < 0; ++i)",
        "test_bridge", "BulletDecoupled.ABodyOnATableIsPressed"),
    "copies never put right": (
        BRIDGE + "Bullet/BulletLocalWorld.cpp", "const double part = body.left > h ? h / body.left : 1;", "const double part = 0;",
        "test_bridge", "BulletDecoupled.ABodyOnATableIsPressed"),
    "answers taken in one topology alone": (
        BRIDGE + "Bullet/BulletDecoupledSource.cpp", "	takeAnswer();\n	if (wanted",
        "	if (wanted == ContactThreading::OwnThread) takeAnswer();\n	if (wanted",
        "test_hand_pairs", "All/FeaturePairsOfAHand.GetAlong/contacts_in_the_world"),
    "pairs keep what they remember of other shapes": (
        COLLISION + "Dispatch/btISTCollisionAlgorithm.cpp", "	m_contact->kept.forget();\n	m_contact->memory.reset();",
        "	m_contact->memory.reset();",
        "test_world_pairs", "All/FeaturePairsOfAWorld.GetAlong/a_scaled_shape"),
    "impulses as if they had come at once": (
        BRIDGE + "Bullet/BulletWorldCoupling.cpp", "const double late = std::min(", "const double late = 0 * std::min(",
        "test_bridge", "BulletDecoupled.AFreeBodyIsPushedAlikeAtAnyRate"),
}


class Tree:
    """A copy of the source tree with its build folder."""

    def __init__(self, source, place, options):
        self.root = place / "source"
        self.build = place / "build"
        skipped = shutil.ignore_patterns("build*", ".git", "shared", "*.ist")
        shutil.copytree(source, self.root, ignore=skipped)
        # The copy lies somewhere else every time; without this ccache would never find anything again.
        self.environment = dict(os.environ, CCACHE_BASEDIR=str(place), CCACHE_NOHASHDIR="1")
        self.call("cmake", "-S", str(self.root), "-B", str(self.build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                  "-DBULLETHAPTICS_TOOLS=OFF", "-DBULLETHAPTICS_DEMOS=OFF", "-DBULLETHAPTICS_WERROR=OFF", *options)

    def call(self, *command):
        done = subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: {done.returncode}\n{done.stdout[-4000:]}")

    def failures(self, target, tests):
        """Names of the tests that failed; exits when none was run, or when the program could not be built or did not end by itself."""
        self.call("cmake", "--build", str(self.build), "--target", target)
        program = next(p for p in self.build.rglob(target) if p.is_file() and os.access(p, os.X_OK))
        done = subprocess.run([program, f"--gtest_filter={tests}"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900)
        ran = re.search(r"(\d+) tests? from .* ran", done.stdout)
        if not ran or ran.group(1) == "0":
            sys.exit(f"{target} --gtest_filter={tests}: no test was run to its end\n{done.stdout[-4000:]}")
        return sorted(set(re.findall(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", done.stdout)))

    def mutate(self, name):
        """Returns what undoes it."""
        file, old, new = MUTATIONS[name][:3]
        path = self.root / file
        text = path.read_text()
        path.write_text(text.replace(old, new))
        return lambda: path.write_text(text)


def misfits(source):
    """A sentence for each mutation whose text does not stand in its file exactly once."""
    counts = {name: (source / file).read_text().count(old) for name, (file, old, *_) in MUTATIONS.items()}
    return [f"{name}: {MUTATIONS[name][0]} holds {count} times instead of once: {MUTATIONS[name][1]!r}"
            for name, count in counts.items() if count != 1]


def tests_of(program, chosen):
    """Names of the tests that the program would run."""
    text = subprocess.run([program, "--gtest_list_tests", f"--gtest_filter={chosen}"], stdout=subprocess.PIPE, text=True, check=True).stdout
    names, suite = set(), ""
    for line in text.splitlines():
        if line.startswith("  "):
            names.add(suite + line.split("#")[0].strip())
        else:
            suite = line.split("#")[0].strip()
    return names


def noticed_by_quick_tests(programs):
    """Prints the mutations that ./test.sh may let pass; returns the share that it notices."""
    excluded = {pathlib.Path(program).name: (program, rest) for program, _, rest in (row.partition("=") for row in programs)}
    missed = []
    for name, (*_, target, tests) in MUTATIONS.items():
        program, rest = excluded.get(target, (None, None))
        named = tests_of(program, tests) if program else set()
        if not named or named != tests_of(program, f"{tests}-{rest}" if rest else tests):
            missed.append(f"{name}: ./test.sh does not run {target} --gtest_filter={tests}")
    share = 1 - len(missed) / len(MUTATIONS)
    print("\n".join(missed + [f"{len(MUTATIONS) - len(missed)} of {len(MUTATIONS)} mutations are noticed by ./test.sh"]))
    return share


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--only", choices=MUTATIONS)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--quick", nargs="+")
    known, options = parser.parse_known_args()
    if wrong := misfits(known.source):
        sys.exit("\n".join(wrong))
    if known.check:
        return
    if known.quick:
        sys.exit(0 if noticed_by_quick_tests(known.quick) >= 0.9 else "fewer than nine tenths")
    options = [o for o in options if o != "--"]
    names = [known.only] if known.only else list(MUTATIONS)
    survivors = 0
    with tempfile.TemporaryDirectory(prefix="mutation_") as place:
        tree = Tree(known.source.resolve(), pathlib.Path(place), options)
        for target in sorted({MUTATIONS[n][3] for n in names}):
            tests = ":".join(sorted({MUTATIONS[n][4] for n in names if MUTATIONS[n][3] == target}))
            if failed := tree.failures(target, tests):
                sys.exit(f"fails without any mutation: {', '.join(failed)}")
        print(f"{len(names)} mutations; their tests pass without them", flush=True)
        for name in names:
            undo = tree.mutate(name)
            failed = tree.failures(*MUTATIONS[name][3:])
            undo()
            survivors += not failed
            print(f"{name}: " + (f"noticed by {', '.join(failed)}" if failed else f"NOT NOTICED by {MUTATIONS[name][4]}"), flush=True)
    sys.exit(f"{survivors} mutations went unnoticed" if survivors else 0)


main()
