// SPDX-License-Identifier: Zlib
// What is read of a mesh file before assimp: archives, their contents, the units in their XML, the text of OBJ. Any bytes give a unit or
// a refusal.
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"
#include "BulletISTCollision/Core/Import/Formats/ZipArchive.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"

#include "tests/fuzz/Invariants.h"

#include <cmath>
#include <string_view>

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const std::string_view bytes(reinterpret_cast<const char*>(data), size);
	for (const char* path : {"mesh.3mf", "mesh.amf", "mesh.zae", "mesh.obj"})
	{
		const ist::Result<ist::MeshFileHead> head = ist::meshFileHead(path, bytes);
		if (!fuzz::accepted(head)) continue;
		require(std::isfinite(head.value().unit.metres) && head.value().unit.metres >= 0, "a unit is a length, or 0 where it is not known");
		require(head.value().unit.metres > 0 || !head.value().unit.stated.empty(), "a unit that is not known stands in the file");
	}
	if (const auto archive = ist::ZipArchive::open(bytes))
		for (const std::string& name : archive->names()) (void)archive->read(name);
	int tags = 0;
	for (ist::XmlTags walk(bytes); walk.next(); ++tags)
		require(walk.name().size() <= size && walk.attribute("unit").value_or("").size() <= size, "names and values are parts of the text");
	require(tags <= static_cast<int>(size), "each tag takes a byte or more");
	return 0;
}
