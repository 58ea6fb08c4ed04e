// SPDX-License-Identifier: Zlib
// Meshes with arbitrary damage. The repair must give a closed mesh or refuse.
#include "BulletISTCollision/Core/Repair/MeshRepair.h"

#include "tests/fuzz/Invariants.h"

#include <bit>
#include <cmath>
#include <cstring>

using fuzz::require;

namespace
{
/// The first two bytes give the number of corners and the kind of their coordinates: small whole numbers, or the bits of floats.
/// Corners follow, then triangles of three bytes each.
ist::Mesh meshOf(const std::uint8_t* data, std::size_t size)
{
	ist::Mesh mesh;
	if (size < 2) return mesh;
	const std::size_t corners = 1 + data[0] % 64u, width = data[1] % 4 == 3 ? 4 : 1;
	std::size_t at = 2;
	for (; mesh.vertices.size() < corners && at + 3 * width <= size; at += 3 * width)
	{
		double x[3];
		for (std::size_t k = 0; k < 3; ++k)
		{
			std::uint32_t bits = 0;
			std::memcpy(&bits, data + at + width * k, width);
			x[k] = width == 4 ? double(std::bit_cast<float>(bits)) : 0.1 * double(bits);
		}
		mesh.vertices.push_back({x[0], x[1], x[2]});
	}
	if (mesh.vertices.empty()) return mesh;
	const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
	for (; at + 3 <= size && mesh.triangles.size() < 200; at += 3)
		mesh.triangles.push_back({data[at] % count, data[at + 1] % count, data[at + 2] % count});
	return mesh;
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Mesh mesh = meshOf(data, size);
	for (const ist::Vec3& p : mesh.vertices)
		if (!ist::isFinite(p)) return 0;  // importMesh refuses such meshes
	for (const ist::RepairMode mode : {ist::RepairMode::Auto, ist::RepairMode::Off, ist::RepairMode::Ground})
	{
		const ist::Result<ist::RepairedMesh> repaired = ist::repair(mesh, mode, {}, 1, {{1, 1}, 1});
		if (!fuzz::accepted(repaired)) continue;
		require(ist::inspect(repaired.value().mesh).watertight, "what was repaired is closed");
		require(repaired.value().volumeAfter > 0 && std::isfinite(repaired.value().volumeAfter), "it has a volume");
	}
	return 0;
}
