// SPDX-License-Identifier: Zlib
// libFuzzer on the asset loader: for any bytes it refuses them, or gives a tree that is safe to query and to write again.
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/SurfaceOverlap.h"

#include "SealedAsset.h"
#include "tests/fuzz/Invariants.h"

namespace
{
void load(const std::vector<std::byte>& bytes)
{
	const ist::Result<ist::InnerSphereTree> tree = ist::decodeAsset(bytes.data(), bytes.size());
	if (!fuzz::accepted(tree)) return;
	fuzz::require(tree.value().validate().empty(), "a loaded tree is valid");
	static ist::QueryWorkspace workspace;
	const double step = tree.value().box.longestSide() / 3;
	(void)ist::queryOverlap(tree.value(), tree.value(), {{}, {step, step / 2, 0}}, workspace);
	static ist::SurfaceWorkspace surfaceWorkspace;
	(void)ist::surfaceOverlap(tree.value().surface, tree.value().surface, {{}, {step, step / 2, 0}}, surfaceWorkspace);
	const std::vector<std::byte> again = ist::encodeAsset(tree.value());
	const ist::Result<ist::InnerSphereTree> back = ist::decodeAsset(again.data(), again.size());
	fuzz::require(static_cast<bool>(back), "a loaded tree can be written and read");
	fuzz::require(ist::encodeAsset(back.value()) == again, "writing is stable");
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
	const auto* first = reinterpret_cast<const std::byte*>(data);
	std::vector<std::byte> bytes(first, first + size);
	load(bytes);
	seal::seal(bytes);
	load(bytes);
	return 0;
}
