// SPDX-License-Identifier: Zlib
// A client of ignition-physics5, as Gazebo is one: client SCENE SECONDS. It plays a scene with Bullet's plug-in, prints where each link is
// at the end, exactly, and says on stderr what does not hold. The bounds come from closed forms about the ideal tori and gears, of which
// the meshes are inscribed polyhedra. Exit code: 0 everything holds, 1 not, 2 the scene cannot be played.
#include <ignition/common/Mesh.hh>
#include <ignition/common/SubMesh.hh>
#include <ignition/math/Inertial.hh>
#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/FrameSemantics.hh>
#include <ignition/physics/Joint.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/mesh/MeshShape.hh>
#include <ignition/physics/sdf/ConstructJoint.hh>
#include <ignition/physics/sdf/ConstructLink.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/Joint.hh>
#include <sdf/JointAxis.hh>
#include <sdf/Link.hh>
#include <sdf/Model.hh>
#include <sdf/Root.hh>
#include <sdf/World.hh>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace
{
namespace physics = ignition::physics;
using ignition::math::Pose3d;
using ignition::math::Vector3d;

struct Features : physics::FeatureList<physics::sdf::ConstructSdfWorld, physics::sdf::ConstructSdfModel, physics::sdf::ConstructSdfLink,
					  physics::sdf::ConstructSdfJoint, physics::mesh::AttachMeshShapeFeature, physics::LinkFrameSemantics,
					  physics::SetJointVelocityCommandFeature, physics::ForwardStep>
{};
using World = physics::World3dPtr<Features>;
using Model = physics::Model3dPtr<Features>;
using Link = physics::Link3dPtr<Features>;
using Joint = physics::Joint3dPtr<Features>;

constexpr double kPi = 3.14159265358979323846, kGravity = 9.8, kStep = 1e-3;
constexpr double kRing = 0.1, kTube = 0.03;  // radii of a torus [m]
constexpr int kRingParts = 48, kTubeParts = 24, kTeeth = 12;
constexpr double kTip = 0.11, kRoot = 0.085, kThickness = 0.04, kDistance = kTip + kRoot + 0.003;  // of the gears [m]

// The most that a mesh lies inside of its torus [m].
const double kFacets = (kRing + kTube) * (1 - std::cos(kPi / kRingParts)) + kTube * (1 - std::cos(kPi / kTubeParts));

bool holds = true;

void expect(bool isSo, const char* what, double value)
{
	if (!isSo) std::fprintf(stderr, "does not hold: %s (%g)\n", what, value);
	holds = holds && isSo;
}

/// Triangles with three vertices each, as meshes of a renderer have.
class Triangles
{
public:
	void add(const Vector3d& a, const Vector3d& b, const Vector3d& c)
	{
		for (const Vector3d& p : {a, b, c})
		{
			m_mesh.AddIndex(m_mesh.VertexCount());
			m_mesh.AddVertex(p);
			m_mesh.AddNormal((b - a).Cross(c - a).Normalized());
		}
	}
	std::unique_ptr<ignition::common::Mesh> mesh() const
	{
		auto result = std::make_unique<ignition::common::Mesh>();
		result->AddSubMesh(m_mesh);
		return result;
	}

private:
	ignition::common::SubMesh m_mesh;
};

/// About the z axis.
std::unique_ptr<ignition::common::Mesh> torus()
{
	const auto point = [](int i, int j) {
		const double u = 2 * kPi * (i % kRingParts) / kRingParts, v = 2 * kPi * (j % kTubeParts) / kTubeParts;
		const double r = kRing + kTube * std::cos(v);
		return Vector3d(r * std::cos(u), r * std::sin(u), kTube * std::sin(v));
	};
	Triangles triangles;
	for (int i = 0; i < kRingParts; ++i)
		for (int j = 0; j < kTubeParts; ++j)
		{
			triangles.add(point(i, j), point(i + 1, j), point(i + 1, j + 1));
			triangles.add(point(i, j), point(i + 1, j + 1), point(i, j + 1));
		}
	return triangles.mesh();
}

/// About the z axis, with a tooth at angle 0. Teeth are trapezoids that leave 4 % of a pitch of play.
std::unique_ptr<ignition::common::Mesh> gear()
{
	constexpr double kCorners[4] = {-0.32, -0.14, 0.14, 0.32};  // of a tooth, in pitches
	const auto point = [&](int i, double z) {
		const int corner = i % 4, tooth = i / 4 % kTeeth;
		const double angle = 2 * kPi * (tooth + kCorners[corner]) / kTeeth, r = corner == 1 || corner == 2 ? kTip : kRoot;
		return Vector3d(r * std::cos(angle), r * std::sin(angle), z);
	};
	const Vector3d top(0, 0, kThickness / 2), bottom(0, 0, -kThickness / 2);
	Triangles triangles;
	for (int i = 0; i < 4 * kTeeth; ++i)
	{
		const Vector3d a = point(i, bottom.Z()), b = point(i + 1, bottom.Z()), c = point(i, top.Z()), d = point(i + 1, top.Z());
		triangles.add(a, b, d);
		triangles.add(a, d, c);
		triangles.add(top, c, d);
		triangles.add(bottom, b, a);
	}
	return triangles.mesh();
}

class Scene
{
public:
	Scene()
	{
		ignition::plugin::Loader loader;
		loader.LoadLib(ENGINE);
		const auto engine = physics::RequestEngine3d<Features>::From(loader.Instantiate("ignition::physics::bullet::Plugin"));
		if (!engine) throw "no engine";
		sdf::Root root;
		// A ground whose top is at 0, and four walls around a square of 0.6 m, all boxes.
		const auto box = [](const std::string& name, const std::string& at, const std::string& size) {
			return "<model name='" + name + "'><static>1</static><pose>" + at +
				" 0 0 0</pose><link name='l'><collision name='c'><geometry>" + "<box><size>" + size +
				"</size></box></geometry></collision></link></model>";
		};
		const std::string text = "<sdf version='1.9'><world name='w'><gravity>0 0 -" + std::to_string(kGravity) + "</gravity>" +
			box("ground", "0 0 -0.5", "4 4 1") + box("east", "0.35 0 0.5", "0.1 1 1") + box("west", "-0.35 0 0.5", "0.1 1 1") +
			box("north", "0 0.35 0.5", "1 0.1 1") + box("south", "0 -0.35 0.5", "1 0.1 1") + "</world></sdf>";
		if (!root.LoadSdfString(text).empty() || !root.WorldByIndex(0)) throw "the world's text is wrong";
		m_world = engine->ConstructWorld(*root.WorldByIndex(0));
	}

	Model add(const std::unique_ptr<ignition::common::Mesh>& mesh, const Pose3d& pose, const Vector3d& inertia, bool fixed = false)
	{
		sdf::Model sdfModel;
		sdfModel.SetName("m" + std::to_string(links.size()));
		sdfModel.SetRawPose(pose);
		sdfModel.SetStatic(fixed);
		const Model model = m_world->ConstructModel(sdfModel);
		sdf::Link sdfLink;
		sdfLink.SetName("link");
		sdfLink.SetInertial({ignition::math::MassMatrix3d(1, inertia, Vector3d::Zero), Pose3d::Zero});
		links.push_back(model->ConstructLink(sdfLink));
		links.back()->AttachMeshShape("mesh", *mesh);
		return model;
	}
	Model addTorus(const Pose3d& pose, bool fixed = false)
	{
		const double across = kRing * kRing / 2 + kTube * kTube * 5 / 8, about = kRing * kRing + kTube * kTube * 3 / 4;
		return add(torus(), pose, {across, across, about}, fixed);
	}
	void step()
	{
		physics::ForwardStep::Output output;
		physics::ForwardStep::State state;
		physics::ForwardStep::Input input;
		input.Get<std::chrono::steady_clock::duration>() = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
			std::chrono::duration<double>(kStep));
		m_world->Step(output, state, input);
	}
	Vector3d center(size_t i) const { return vector(links[i]->FrameDataRelativeToWorld().pose.translation()); }
	/// Direction of the link's own z or x axis.
	Vector3d axis(size_t i, int column) const { return vector(links[i]->FrameDataRelativeToWorld().pose.linear().col(column)); }
	double speed(size_t i) const { return links[i]->FrameDataRelativeToWorld().linearVelocity.norm(); }
	double energy() const
	{
		double sum = 0;
		for (size_t i = 0; i < links.size(); ++i) sum += kGravity * center(i).Z() + speed(i) * speed(i) / 2;
		return sum;
	}
	void print() const
	{
		for (size_t i = 0; i < links.size(); ++i) std::printf("%zu %a %a %a\n", i, center(i).X(), center(i).Y(), center(i).Z());
	}

	std::vector<Link> links;

private:
	template <class Vector> static Vector3d vector(const Vector& v) { return {v[0], v[1], v[2]}; }

	World m_world;
};

/// How far two ideal tori lie in each other: the distance of their circles, sampled on one of them.
double overlap(const Scene& scene, size_t one, size_t other)
{
	const Vector3d x = scene.axis(one, 0), z = scene.axis(one, 2), y = z.Cross(x), n = scene.axis(other, 2), c = scene.center(other);
	double nearest = 1e300;
	for (int k = 0; k < 720; ++k)
	{
		const double angle = kPi * k / 360;
		const Vector3d p = scene.center(one) + (x * std::cos(angle) + y * std::sin(angle)) * kRing - c;
		const double height = p.Dot(n), out = (p - n * height).Length() - kRing;
		nearest = std::min(nearest, std::hypot(height, out));
	}
	return 2 * kTube - nearest;
}

double deepestPair(const Scene& scene)
{
	double deepest = -1;
	for (size_t i = 0; i < scene.links.size(); ++i)
		for (size_t j = 0; j < i; ++j) deepest = std::max(deepest, overlap(scene, i, j));
	return deepest;
}

/// A torus lies on the ground: not above it, and at most 0.5 % of its thickness deep.
void playTorus(double seconds)
{
	Scene scene;
	scene.addTorus({0, 0, kTube + 0.01, 0, 0, 0});
	for (double t = 0; t < seconds; t += kStep) scene.step();
	const double depth = kTube - scene.center(0).Z();
	std::fprintf(stderr, "depth %.3f mm\n", 1e3 * depth);
	expect(depth > -1e-4 && depth < 0.005 * 2 * kTube, "depth of a torus on the ground [m]", depth);
	scene.print();
}

/// Ten tori fall into a bin.
void playPile(double seconds)
{
	Scene scene;
	for (int i = 0; i < 10; ++i)
		scene.addTorus({0.02 * (i % 3 - 1), 0.03 * (i % 2), 0.1 + 0.16 * i, 0.2 * (i % 3), 0.1 * (i % 4), 0.5 * i});
	expect(deepestPair(scene) < 0, "the tori begin inside of each other [m]", deepestPair(scene));
	const double before = scene.energy();
	double highest = before;
	for (double t = 0; t < seconds; t += kStep)
	{
		scene.step();
		highest = std::max(highest, scene.energy());
	}
	double fastest = 0, lowest = 1e300, farthest = 0;
	for (size_t i = 0; i < scene.links.size(); ++i)
	{
		fastest = std::max(fastest, scene.speed(i));
		lowest = std::min(lowest, scene.center(i).Z());
		farthest = std::max({farthest, std::fabs(scene.center(i).X()), std::fabs(scene.center(i).Y())});
	}
	const double deepest = deepestPair(scene);
	std::fprintf(stderr, "deepest pair %.3f mm (facets %.3f mm), lowest %.3f mm, fastest %.4f m/s, energy %.3f J, at most %.3f J\n",
		1e3 * deepest, 1e3 * kFacets, 1e3 * lowest, fastest, before, highest);
	expect(deepest < 0.03 * 2 * kTube + 2 * kFacets, "deepest pair of tori [m]", deepest);
	expect(lowest > kTube - 0.03 * 2 * kTube - kFacets, "lowest centre [m]", lowest);
	expect(farthest < 0.3, "a torus has left the bin [m]", farthest);
	expect(highest < before * 1.001, "energy that came from nowhere [J]", highest);
	expect(fastest < 0.05, "a torus still moves [m/s]", fastest);
	scene.print();
}

/// A gear that is driven turns another one, and no tooth slips.
void playGears(double seconds)
{
	Scene scene;
	const double about = kRoot * kRoot / 2, across = about / 2 + kThickness * kThickness / 12;
	std::vector<Joint> joints;
	// A tooth of the first points to a gap of the second.
	for (int i = 0; i < 2; ++i)
	{
		const Model model = scene.add(gear(), {i * kDistance - kDistance / 2, 0, 0.3, 0, 0, i * kPi / kTeeth}, {across, across, about});
		sdf::Joint joint;
		joint.SetName("hinge");
		joint.SetType(sdf::JointType::REVOLUTE);
		joint.SetParentLinkName("world");
		joint.SetChildLinkName("link");
		sdf::JointAxis axis;
		(void)axis.SetXyz(Vector3d::UnitZ);
		joint.SetAxis(0, axis);
		joints.push_back(model->ConstructJoint(joint));
		if (!joints.back()) throw "no hinge";
	}
	constexpr double kSpeed = 2;  // [rad/s]
	double turned[2] = {0, 0}, slip = 0, farthest = 0, fastest = 0;
	Vector3d last[2] = {scene.axis(0, 0), scene.axis(1, 0)};
	const Vector3d begin[2] = {scene.center(0), scene.center(1)};
	for (double t = 0; t < seconds; t += kStep)
	{
		joints[0]->SetVelocityCommand(0, kSpeed);
		scene.step();
		for (size_t i = 0; i < 2; ++i)
		{
			const Vector3d now = scene.axis(i, 0);
			const double turn = std::atan2(last[i].Cross(now).Z(), last[i].Dot(now));
			turned[i] += turn;
			last[i] = now;
			farthest = std::max(farthest, (scene.center(i) - begin[i]).Length());
			fastest = std::max(fastest, std::fabs(turn) / kStep);
		}
		slip = std::max(slip, std::fabs(turned[0] + turned[1]));
	}
	const double pitch = 2 * kPi / kTeeth;
	std::fprintf(stderr, "turned %.3f and %.3f rad, slip %.3f of a pitch, off the axes by %.3f mm, fastest %.3f rad/s\n", turned[0],
		turned[1], slip / pitch, 1e3 * farthest, fastest);
	expect(std::fabs(turned[0]) > 0.9 * kSpeed * seconds, "the driven gear is held back [rad]", turned[0]);
	expect(slip < 0.3 * pitch, "teeth slip or pass through [rad]", slip);
	expect(farthest < 0.002, "a gear leaves its axis [m]", farthest);
	expect(fastest < 10 * kSpeed, "a gear is kicked [rad/s]", fastest);
	scene.print();
}

/// Six rings hang in each other, the first one fixed: each as far below the one before as the insides of two tori let it.
void playChain(double seconds)
{
	Scene scene;
	const double apart = 2 * (kRing - kTube);
	// Upright, each a quarter turn about the vertical from the one before, 1 mm above where it will hang.
	for (int i = 0; i < 6; ++i) scene.addTorus({0, 0, 1.5 - i * (apart - 0.001), kPi / 2, 0, i % 2 * kPi / 2}, i == 0);
	double deepest = 0, longest = 0, shortest = 1e300;
	for (double t = 0; t < seconds; t += kStep)
	{
		scene.step();
		deepest = std::max(deepest, deepestPair(scene));
	}
	for (size_t i = 1; i < scene.links.size(); ++i)
	{
		const double distance = (scene.center(i - 1) - scene.center(i)).Length();
		longest = std::max(longest, distance);
		shortest = std::min(shortest, distance);
	}
	const double atEnd = deepestPair(scene);
	std::fprintf(stderr, "centres %.3f to %.3f mm apart (%.3f), deepest %.3f mm, at the end %.3f mm (facets %.3f mm)\n", 1e3 * shortest,
		1e3 * longest, 1e3 * apart, 1e3 * deepest, 1e3 * atEnd, 1e3 * kFacets);
	expect(deepest < 0.25 * 2 * kTube, "depth while the chain comes to rest [m]", deepest);
	expect(atEnd < 0.005 * 2 * kTube + 2 * kFacets, "depth of rings that hang [m]", atEnd);
	expect(shortest > 0.9 * apart && longest < 1.05 * apart, "distance of rings that hang [m]", longest);
	scene.print();
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc != 3) return 2;
	const std::string scene = argv[1];
	const double seconds = std::atof(argv[2]);
	try
	{
		if (scene == "torus") playTorus(seconds);
		else if (scene == "pile") playPile(seconds);
		else if (scene == "gears") playGears(seconds);
		else if (scene == "chain") playChain(seconds);
		else return 2;
	}
	catch (const char* reason)
	{
		std::fprintf(stderr, "%s\n", reason);
		return 2;
	}
	return holds ? 0 : 1;
}
