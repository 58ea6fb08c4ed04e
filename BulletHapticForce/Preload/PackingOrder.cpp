// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Preload/PackingOrder.h"

#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Build/TreeCache.h"

#include <array>
#include <fstream>
#include <iterator>

#include <unistd.h>

namespace preload
{
ist::BuildOptions buildOptions(int spheres)
{
	ist::BuildOptions options;
	options.maxSpheres = spheres;
	options.threads = 1;  // the game keeps the other cores
	return options;
}

std::string PackingOrder::key() const { return ist::treeKeyText(mesh, buildOptions(spheres)); }

bool PackingOrder::write(const std::filesystem::path& path) const
{
	ist::ByteWriter bytes;
	bytes.reserve(32 + mesh.vertices.size() * sizeof(ist::Vec3) + mesh.triangles.size() * 12);
	bytes.i64(spheres);
	bytes.f64(mesh.rounding);
	bytes.u64(mesh.vertices.size());
	for (const ist::Vec3& vertex : mesh.vertices) bytes.vec3(vertex);
	bytes.u64(mesh.triangles.size());
	for (const std::array<uint32_t, 3>& triangle : mesh.triangles)
		for (const uint32_t corner : triangle) bytes.u32(corner);
	const std::filesystem::path part = path.string() + "." + std::to_string(getpid());
	std::ofstream file(part, std::ios::binary | std::ios::trunc);
	file.write(reinterpret_cast<const char*>(bytes.bytes().data()), std::streamsize(bytes.size()));
	file.close();
	std::error_code failure;
	if (file) std::filesystem::rename(part, path, failure);
	if (file && !failure) return true;
	std::filesystem::remove(part, failure);
	return false;
}

std::optional<PackingOrder> PackingOrder::read(const std::filesystem::path& path)
{
	std::ifstream file(path, std::ios::binary);
	const std::string text{std::istreambuf_iterator<char>(file), {}};
	ist::ByteReader bytes(reinterpret_cast<const std::byte*>(text.data()), text.size());
	PackingOrder order;
	order.spheres = int(bytes.i64());
	order.mesh.rounding = bytes.f64();
	order.mesh.vertices.resize(bytes.count(24));
	for (ist::Vec3& vertex : order.mesh.vertices) vertex = bytes.vec3();
	order.mesh.triangles.resize(bytes.count(12));
	for (std::array<uint32_t, 3>& triangle : order.mesh.triangles)
		for (uint32_t& corner : triangle) corner = bytes.u32();
	return bytes.complete() ? std::optional(std::move(order)) : std::nullopt;
}
}  // namespace preload
