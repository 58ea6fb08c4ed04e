// SPDX-License-Identifier: Zlib
// Prints a hash of everything that queries of two bodies answer in seeded poses: one line for each kind of query. Machines that print the
// same lines agree bit for bit. BULLETHAPTICS_ISA chooses the instruction set: sets with as many lanes print the same lines, and all sets
// the same lines of surfaces and of pairs.
// Usage: query_hashes TREE TREE [POSES=40]
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Base/CounterRandom.h"
#include "BulletISTCollision/Core/Faces/ContactFaces.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "BulletISTCollision/Core/Query/VerletList.h"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace ist;

namespace
{
/// FNV-1a over the bits of numbers.
class Hash
{
public:
	void add(uint64_t bits)
	{
		for (int i = 0; i < 64; i += 8) m_value = (m_value ^ (bits >> i & 0xff)) * 0x100000001b3ull;
	}
	void add(double x)
	{
		uint64_t bits;
		std::memcpy(&bits, &x, sizeof bits);
		add(bits);
	}
	void add(const Vec3& v)
	{
		for (int i = 0; i < 3; ++i) add(v[i]);
	}
	void add(const Wrench& w)
	{
		add(w.force);
		add(w.torque);
	}
	template <size_t N> void add(const double (&numbers)[N])
	{
		for (const double x : numbers) add(x);
	}
	uint64_t value() const { return m_value; }

private:
	uint64_t m_value = 0xcbf29ce484222325ull;
};

void add(Hash& h, const OverlapIntegrals& o)
{
	for (const double x : {o.volume, o.depthA, o.depthB, o.surfaceVolume, o.slidingVolumeA, o.slidingVolumeB, o.forceVariance,
			 o.volumeVariance, o.pressedA, o.pressedB})
		h.add(x);
	for (const Vec3& v : {o.firstMoment, o.areaVector}) h.add(v);
	for (const Wrench& w : {o.normalA, o.normalB, o.line}) h.add(w);
	h.add(o.secondMoment);
	for (const SymmetricMatrix6* m : {&o.stiffnessA, &o.stiffnessB, &o.damping}) h.add(m->m);
	h.add(uint64_t(o.pairs));
}

void add(Hash& h, const ContactFace& f)
{
	for (const Vec3& v : {f.center, f.areaNormal, f.pressure, f.pressureCenter, f.gradient}) h.add(v);
	for (const double x : {f.area, f.depth, f.cut, f.error}) h.add(x);
	h.add(uint64_t(f.element));
	h.add(uint64_t(f.cell));
}

/// The order of summation depends on the number of lanes, so a list of pairs is hashed without the sums.
void add(Hash& h, const OverlapResult& r, bool isList)
{
	if (!isList) add(h, r.total);
	for (int p = 0; p < r.patchCount && !isList; ++p) add(h, r.patches[p]);
	for (int i = 0; i < r.pairCount; ++i)
	{
		const OverlapPair& pair = r.pairs[i];
		h.add(uint64_t(pair.ballA) << 32 | pair.ballB);
		h.add(pair.lens);
		h.add(pair.area);
		h.add(pair.centroid);
		h.add(pair.normal);
	}
	for (size_t i = 0; i < r.faceCountA; ++i) add(h, r.facesA[i]);
	for (size_t i = 0; i < r.faceCountB; ++i) add(h, r.facesB[i]);
}

/// Random rotation, and centres at most the mean of both sizes apart.
Pose randomPose(const InnerSphereTree& A, const InnerSphereTree& B, uint64_t number)
{
	CounterRandom random(1, number, 0);
	double q[4], n;
	do {
		for (double& x : q) x = 2 * random.next() - 1;
		n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
	} while (n > 1 || n < 0.01);
	for (double& x : q) x /= std::sqrt(n);
	Pose X;
	X.rotation = rotationMatrix({q[0], q[1], q[2], q[3]});
	const double distance = 0.5 * (A.box.longestSide() + B.box.longestSide()) * random.next();
	X.translation = A.origin + distance * random.direction() - X.rotation * B.origin;
	return X;
}

struct Kind
{
	const char* name;
	bool ofSurfaces, hasList;
	QueryOptions options;
};

std::vector<Kind> kinds()
{
	QueryOptions full, sums, sorted, meeting, paper, coarse;
	full.damping = sorted.damping = coarse.damping = {0.3, 0.8};
	sums.patches = false;
	sorted.sortPairs = true;
	meeting.listMeetingBounds = meeting.sortPairs = true;
	paper.model = Model::Inner;
	coarse.level = 1;
	return {{"surfaces", true, false, full}, {"patches of leaves", false, false, full}, {"sums of leaves", false, false, sums},
		{"pairs of leaves", false, false, sorted}, {"pairs that meet", false, false, meeting}, {"packed spheres", false, false, paper},
		{"Verlet list", false, true, full}, {"merged leaves", false, false, coarse}};
}

/// Hash of the answers in `poses` poses, each moved a little twice, as a Verlet list wants it.
void print(const Kind& kind, const InnerSphereTree& A, const InnerSphereTree& B, int poses)
{
	QueryWorkspace workspace;
	VerletList list;
	Hash hash;
	int64_t pairs = 0;
	for (int i = 0; i < poses; ++i)
	{
		Pose X = randomPose(A, B, uint64_t(i));
		for (int step = 0; step < 3; ++step)
		{
			const OverlapResult r = queryOverlap(A, B, X, workspace, kind.options, kind.hasList ? &list : nullptr);
			if (r.status != QueryStatus::Ok)
			{
				std::printf("%-18s %s\n", kind.name, toString(r.status));
				return;
			}
			add(hash, r, kind.options.sortPairs);
			pairs += r.total.pairs;
			X.translation = X.translation + Vec3{1e-4, 2e-4, -1e-4} * A.box.longestSide();
		}
	}
	std::printf("%-18s %9" PRId64 " pairs %016" PRIx64 "\n", kind.name, pairs, hash.value());
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc < 3 || argc > 4)
	{
		std::fprintf(stderr, "usage: query_hashes TREE TREE [POSES=40]\n");
		return 2;
	}
	Result<InnerSphereTree> trees[2] = {loadAsset(argv[1]), loadAsset(argv[2])};
	for (const Result<InnerSphereTree>& tree : trees)
		if (!tree)
		{
			std::fprintf(stderr, "query_hashes: %s\n", tree.error().message.c_str());
			return 1;
		}
	InnerSphereTree leaves[2] = {trees[0].value(), trees[1].value()};
	for (InnerSphereTree& body : leaves) body.surface = {};
	const int poses = argc > 3 ? std::atoi(argv[3]) : 40;
	for (const Kind& kind : kinds())
		if (kind.ofSurfaces) print(kind, trees[0].value(), trees[1].value(), poses);
		else print(kind, leaves[0], leaves[1], poses);
	return 0;
}
