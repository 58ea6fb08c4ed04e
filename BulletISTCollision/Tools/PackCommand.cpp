// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetArchive.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Tools/OutputFile.h"
#include "BulletISTCollision/Tools/Report.h"

#include <algorithm>
#include <cstdio>

namespace ist::tools
{
namespace
{
double leafVolume(const InnerSphereTree& tree)
{
	double sum = 0;
	for (const MomentEllipsoid& b : tree.law.slots()) sum += b.volume();
	return sum;
}

/// Describes the loss by rounding. `packed` is the decoded archive of `tree`; its spheres have the same order.
void describeLoss(Report& report, const InnerSphereTree& tree, const InnerSphereTree& packed)
{
	double shift = 0, shrink = 0, share = 0;
	for (size_t i = 0; i < tree.spheres.size(); ++i)
	{
		const Sphere &a = tree.spheres[i], &b = packed.spheres[i];
		shift = std::max(shift, distance(a.center(), b.center()));
		shrink = std::max(shrink, static_cast<double>(a.r) - b.r);
		share = std::max(share, (static_cast<double>(a.r) - b.r) / a.r);
	}
	report["fill_loss"] = tree.fill - packed.fill;
	report["max_center_shift"] = shift;
	report["max_radius_loss"] = shrink;
	report["max_radius_loss_share"] = share;
	report["leaf_volume_change"] = leafVolume(packed) / leafVolume(tree) - 1;
}
}  // namespace

int runPack(const PackArguments& a)
{
	if (const int code = checkOutput(a.output, {a.input}); code != kGood) return code;
	const Result<InnerSphereTree> tree = loadTree(a.input);
	if (!tree) return fail(tree.error().message);
	const Result<std::vector<std::byte>> bytes = encodeArchive(tree.value());
	if (!bytes) return fail(a.input + ": " + bytes.error().message);
	const Result<InnerSphereTree> packed = decodeArchive(bytes.value().data(), bytes.value().size());
	if (!packed) return fail("internal: the archive does not read back: " + packed.error().message, kInternal);
	const Result<size_t> written = saveArchive(tree.value(), a.output);
	if (!written) return fail(written.error().message);
	Report report = newReport();
	report["spheres"] = tree.value().spheres.size();
	report["leaves"] = packed.value().law.ballCount();
	report["bytes"] = written.value();
	report["bytes_per_sphere"] = static_cast<double>(written.value()) / static_cast<double>(tree.value().spheres.size());
	describeLoss(report, tree.value(), packed.value());
	std::fputs(format(report, a.json).c_str(), stdout);
	return kGood;
}

int runUnpack(const PackArguments& a)
{
	if (const int code = checkOutput(a.output, {a.input}); code != kGood) return code;
	const Result<InnerSphereTree> tree = loadTree(a.input);
	if (!tree) return fail(tree.error().message);
	const Result<size_t> written = saveAsset(tree.value(), a.output);
	if (!written) return fail(written.error().message);
	Report report = newReport();
	describeTree(report, tree.value(), written.value());
	std::fputs(format(report, a.json).c_str(), stdout);
	return kGood;
}
}  // namespace ist::tools
