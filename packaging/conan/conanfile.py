# SPDX-License-Identifier: Zlib
"""Conan 2: conan create packaging/conan --build=missing
With the libraries of Debian instead of Conan's: conan create packaging/conan -pr:a packaging/conan/debian.profile"""
import os
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir


class BulletHapticsConan(ConanFile):
    name = "bullethaptics"
    description = "Volumetric contact that can be felt, for Bullet Physics"
    license = "Zlib"
    topics = ("bullet", "physics", "haptics", "collision-detection", "contact")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "assimp": [True, False], "openmp": [True, False]}
    default_options = {"shared": False, "fPIC": True, "assimp": True, "openmp": True}
    implements = ["auto_shared_fpic"]

    @property
    def _checkout(self):
        return os.path.join(self.recipe_folder, "..", "..")

    def set_version(self):
        project = load(self, os.path.join(self._checkout, "CMakeLists.txt"))
        self.version = re.search(r"project\(BulletHaptics VERSION ([\d.]+)", project).group(1)

    def export(self):
        copy(self, "CMakeLists.txt", self._checkout, self.export_folder)

    def export_sources(self):
        folders = ("BulletISTCollision", "BulletHapticForce", "DeviceBridge", "TestSupport", "cmake")
        files = ["CMakeLists.txt", "package.xml", "LICENSE", "docs/Doxyfile.in", "data/devices/*", "data/scenes/*", "packaging/*"]
        for pattern in files + [f + "/*" for f in folders]:
            copy(self, pattern, self._checkout, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        # The headers of both stand in those of this library.
        self.requires("bullet3/[>=3.21 <4]", transitive_headers=True, transitive_libs=True)
        self.requires("eigen/[>=3.3 <4]")
        self.requires("nlohmann_json/[>=3.10 <4]")
        if self.options.assimp:
            self.requires("assimp/[>=5.2 <6]")

    def validate(self):
        check_min_cppstd(self, 20)
        bullet = next((d for r, d in self.dependencies.items() if r.ref.name == "bullet3"), None)
        if bullet and bullet.options.get_safe("double_precision"):
            raise ConanInvalidConfiguration("Conan's Bullet in double precision has the file names of single precision: "
                                            "use bullet3/*:double_precision=False")

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TOOLS", "DEMOS", "TESTS", "PYTHON", "PRELOAD", "PNG", "BENCH", "WERROR"):
            toolchain.cache_variables["BULLETHAPTICS_" + part] = False
        # Drivers of the system's device libraries: such a build is made from the sources, or as Debian packages.
        for driver in ("HAPLY", "OPENXR", "RUMBLE", "SPNAV"):
            toolchain.cache_variables["BULLETHAPTICS_DRIVER_" + driver] = False
        toolchain.cache_variables["BULLETHAPTICS_ASSIMP"] = bool(self.options.assimp)
        toolchain.cache_variables["BULLETHAPTICS_OPENMP"] = bool(self.options.openmp)
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        rmdir(self, os.path.join(self.package_folder, "lib", "pkgconfig"))
        rmdir(self, os.path.join(self.package_folder, "share"))

    def package_info(self):
        # The package's own CMake configuration, with its targets, serves users as it does everywhere else.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs.append(os.path.join("lib", "cmake", "BulletHaptics"))
