// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Commands.h"

#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Tools/NumberText.h"
#include "BulletISTCollision/Tools/OutputFile.h"
#include "BulletISTCollision/Tools/Report.h"

#include <cstdio>
#include <sstream>

namespace ist::tools
{
namespace
{
constexpr const char* kStandardOutput = "-";

void writeSpheres(std::ostream& out, const InnerSphereTree& tree)
{
	out << "x,y,z,r\n";
	for (const Sphere& s : tree.spheres)
	{
		const Vec3 c = s.center() + tree.origin;
		out << numberText(c.x) << ',' << numberText(c.y) << ',' << numberText(c.z) << ',' << numberText(s.r) << '\n';
	}
}

void writeLeaves(std::ostream& out, const InnerSphereTree& tree)
{
	out << "x,y,z,r,density,nx,ny,nz,depth,sphere,xx,yy,zz,xy,xz,yz\n";
	for (const MomentEllipsoid& b : tree.law.slots())
	{
		if (!(b.R > 0)) continue;
		const Vec3 c = b.center() + tree.origin;
		for (double v : {c.x, c.y, c.z}) out << numberText(v) << ',';
		for (float v : {b.R, b.density, b.nx, b.ny, b.nz, b.depth}) out << numberText(v) << ',';
		out << b.sphere;
		for (float v : {b.xx, b.yy, b.zz, b.xy, b.xz, b.yz}) out << ',' << numberText(v);
		out << '\n';
	}
}

int writeFile(const std::string& path, const InnerSphereTree& tree, void (*write)(std::ostream&, const InnerSphereTree&))
{
	std::ostringstream text;
	write(text, tree);
	if (path != kStandardOutput) return writeText(path, text.str());
	std::fputs(text.str().c_str(), stdout);
	return kGood;
}
}  // namespace

int runExport(const ExportArguments& a)
{
	for (const std::string& output : {a.spheres, a.leaves})
		if (const int code = output.empty() || output == kStandardOutput ? kGood : checkOutput(output, {a.file}); code != kGood)
			return code;
	if (a.spheres == kStandardOutput && a.leaves == kStandardOutput)
		return fail("standard output can take spheres or leaves, not both; name a file for one of them");
	if (!a.spheres.empty() && !a.leaves.empty() && isSameFile(a.spheres, a.leaves))
		return fail("\"" + a.leaves + "\" is to hold spheres and leaves; name two files");
	const Result<InnerSphereTree> tree = loadTree(a.file);
	if (!tree) return fail(tree.error().message);
	if (!a.spheres.empty())
		if (const int code = writeFile(a.spheres, tree.value(), writeSpheres); code != kGood) return code;
	if (!a.leaves.empty()) return writeFile(a.leaves, tree.value(), writeLeaves);
	return kGood;
}
}  // namespace ist::tools
