// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTTreeSource.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Registry/btISTShapeMesh.h"
#include "BulletISTCollision/Registry/btISTShapeParts.h"

#include "BulletCollision/BroadphaseCollision/btBroadphaseInterface.h"
#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

#include <algorithm>
#include <filesystem>
#include <unordered_map>
#include <utility>

/// The states that still wait. A state removes itself when it is destroyed.
struct btISTTreeSource::Waiting
{
	std::vector<btISTPendingAttachment::State*> states;
};

struct btISTPendingAttachment::State
{
	const btCollisionShape* shape = nullptr;
	std::shared_ptr<const ist::TreeOrder> order;  // null until an object is near
	std::function<std::shared_ptr<const ist::TreeOrder>()> start;
	std::weak_ptr<btISTTreeSource::Waiting> waiting;
	btVector3 scaling{1, 1, 1};  // scaling for which the tree is made
	btISTAttachment attachment;
	std::string error, note;

	void begin()
	{
		if (!order) order = start();
		start = nullptr;  // also releases the triangles
	}
	bool isDone() const { return order && order->isDone(); }
	~State()
	{
		const auto list = waiting.lock();
		if (list) list->states.erase(std::remove(list->states.begin(), list->states.end(), this), list->states.end());
	}
	void attachTo(btISTRegistry& registry)
	{
		note = order->note();
		if (!order->tree())
		{
			error = order->error();
			return;
		}
		if (!btISTRegistry::hasScaling(*shape, scaling))
		{
			error = "the shape has another local scaling than its tree was made for";
			return;
		}
		ist::Result<btISTAttachment> attached = registry.attachScaled(shape, order->tree());
		if (attached) attachment = std::move(attached).value();
		else error = attached.error().message;
	}
};

void btISTPendingAttachment::Deleter::operator()(State* state) const { delete state; }
btISTPendingAttachment::btISTPendingAttachment(std::unique_ptr<State> state) : m_state(state.release()) {}

namespace
{
const std::string kNothing;
}

bool btISTPendingAttachment::isAttached() const { return m_state && m_state->attachment.isAttached(); }
bool btISTPendingAttachment::isPending() const { return m_state && !isAttached() && m_state->error.empty(); }
const std::string& btISTPendingAttachment::error() const { return m_state ? m_state->error : kNothing; }
const std::string& btISTPendingAttachment::note() const { return m_state ? m_state->note : kNothing; }
const btCollisionShape* btISTPendingAttachment::shape() const { return m_state ? m_state->shape : nullptr; }

std::shared_ptr<const ist::InnerSphereTree> btISTPendingAttachment::tree() const { return isAttached() ? m_state->order->tree() : nullptr; }

btISTTreeSource::btISTTreeSource(btISTRegistry& registry, btISTTreeSettings settings)
	: m_registry(registry),
	  m_settings(std::move(settings)),
	  m_waiting(std::make_shared<Waiting>()),
	  m_worker(std::make_unique<ist::TreeWorker>(m_settings.cacheFolder, m_settings.mostDoubt))
{}

btISTTreeSource::~btISTTreeSource()
{
	m_worker.reset();
	for (auto* state : m_waiting->states) state->error = "the source of the trees is gone";
}

btISTPendingAttachment btISTTreeSource::expect(const btCollisionShape* shape, const btVector3& scaling, Start start)
{
	auto state = std::make_unique<btISTPendingAttachment::State>();
	state->shape = shape;
	state->scaling = scaling;
	state->start = std::move(start);
	if (!m_near) state->begin();
	state->waiting = m_waiting;
	m_waiting->states.push_back(state.get());
	return btISTPendingAttachment(std::move(state));
}

namespace
{
std::string refusalToWait(const btISTRegistry& registry, const btCollisionShape* shape, bool waits)
{
	if (!shape) return "cannot attach a tree to a null shape";
	if (waits) return "the shape waits for a tree already";
	return registry.find(shape) ? "the shape has a tree already; detach it first" : "";
}
}  // namespace

btISTPendingAttachment btISTTreeSource::refused(const btCollisionShape* shape, const std::string& error)
{
	auto state = std::make_unique<btISTPendingAttachment::State>();
	state->shape = shape;
	state->error = error;
	return btISTPendingAttachment(std::move(state));
}

btISTPendingAttachment btISTTreeSource::build(const btCollisionShape* shape, ist::Mesh mesh, const ist::BuildOptions& options)
{
	const auto kept = std::make_shared<ist::Mesh>(std::move(mesh));
	return expect(shape, shape->getLocalScaling(), [this, kept, options] { return m_worker->build(std::move(*kept), options); });
}

btISTPendingAttachment btISTTreeSource::attach(const btCollisionShape* shape)
{
	if (shape && shape->getShapeType() == TERRAIN_SHAPE_PROXYTYPE) return attachGround(shape);
	if (const std::string error = refusalToWait(m_registry, shape, awaits(shape)); !error.empty()) return refused(shape, error);
	ist::Result<ist::Mesh> mesh = meshOfShape(*shape);
	return mesh ? build(shape, std::move(mesh).value(), m_settings.build) : refused(shape, mesh.error().message);
}

btISTPendingAttachment btISTTreeSource::attachGround(const btCollisionShape* shape, double depth, ist::SignedAxis up)
{
	constexpr double kDepth = 0.1;  // of the longest side
	if (const std::string error = refusalToWait(m_registry, shape, awaits(shape)); !error.empty()) return refused(shape, error);
	ist::Result<ist::Mesh> mesh = meshOfShape(*shape);
	if (!mesh) return refused(shape, mesh.error().message);
	ist::BuildOptions options = m_settings.build;
	options.repair = ist::RepairMode::Ground;
	options.ground = {up, depth == 0 ? kDepth * bounds(mesh.value()).longestSide() : depth};
	if (shape->getShapeType() == TERRAIN_SHAPE_PROXYTYPE)
		options.ground.up = {static_cast<const btHeightfieldTerrainShape*>(shape)->getUpAxis(), 1};
	return build(shape, std::move(mesh).value(), options);
}

btISTPendingAttachment btISTTreeSource::attachAsset(const btCollisionShape* shape, const std::string& path)
{
	if (const std::string error = refusalToWait(m_registry, shape, awaits(shape)); !error.empty()) return refused(shape, error);
	return expect(shape, btVector3(1, 1, 1), [this, path] { return m_worker->load(path); });
}

btISTPendingAttachment btISTTreeSource::unknown(const char* name)
{
	return refused(nullptr, std::string("no shape and no body of the loaded file is named \"") + name + "\"");
}

std::vector<std::string> btISTTreeSource::assetNames(const std::string& folder)
{
	std::vector<std::string> names;
	std::error_code ignored;
	for (std::filesystem::directory_iterator entry(folder, ignored), end; !ignored && entry != end; entry.increment(ignored))
		if (entry->path().extension() == ".ist") names.push_back(entry->path().stem().string());
	std::sort(names.begin(), names.end());
	return names;
}

std::vector<btISTPendingAttachment> btISTTreeSource::attachGImpact(const btCollisionWorld& world)
{
	std::vector<btISTPendingAttachment> result;
	const btCollisionObjectArray& objects = world.getCollisionObjectArray();
	for (int i = 0; i < objects.size(); ++i) collectGImpact(objects[i]->getCollisionShape(), result);
	return result;
}

void btISTTreeSource::collectGImpact(const btCollisionShape* shape, std::vector<btISTPendingAttachment>& into)
{
	if (shape->getShapeType() == COMPOUND_SHAPE_PROXYTYPE)
	{
		const auto* compound = static_cast<const btCompoundShape*>(shape);
		for (int i = 0; i < compound->getNumChildShapes(); ++i) collectGImpact(compound->getChildShape(i), into);
	}
	else if (shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE)
	{
		const auto* gimpact = static_cast<const btGImpactShapeInterface*>(shape);
		const bool isMesh = gimpact->getGImpactShapeType() != CONST_GIMPACT_COMPOUND_SHAPE;
		if (isMesh && !m_registry.find(shape) && !awaits(shape)) into.push_back(attach(shape));
	}
}

bool btISTTreeSource::awaits(const btCollisionShape* shape) const
{
	const auto& states = m_waiting->states;
	return std::any_of(states.begin(), states.end(), [shape](const auto* state) { return state->shape == shape; });
}

namespace
{
/// Whether an object is found that is not the object itself and that the collision filters accept. A plane is everywhere for the broad
/// phase.
struct Neighbours : btBroadphaseAabbCallback
{
	const btBroadphaseProxy* self;
	btVector3 lower, upper;
	bool found = false;

	bool process(const btBroadphaseProxy* proxy) override
	{
		const bool filtered = (proxy->m_collisionFilterGroup & self->m_collisionFilterMask) &&
			(self->m_collisionFilterGroup & proxy->m_collisionFilterMask);
		found = found || (proxy != self && filtered && reaches(static_cast<const btCollisionObject*>(proxy->m_clientObject)));
		return !found;
	}
	bool reaches(const btCollisionObject* object) const
	{
		if (object->getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE) return true;
		const auto* plane = static_cast<const btStaticPlaneShape*>(object->getCollisionShape());
		const btVector3 normal = object->getWorldTransform().getBasis() * plane->getPlaneNormal();
		const btScalar offset = plane->getPlaneConstant() + normal.dot(object->getWorldTransform().getOrigin());
		const btVector3 half = (upper - lower) / 2;
		return normal.dot(lower + half) - half.dot(normal.absolute()) <= offset;
	}
};
}  // namespace

bool btISTTreeSource::hasNeighbour(const btCollisionObject& object) const
{
	const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
	if (!proxy) return false;
	const btVector3 sides = proxy->m_aabbMax - proxy->m_aabbMin, margin = btVector3(1, 1, 1) * sides[sides.maxAxis()];
	Neighbours neighbours;
	neighbours.self = proxy;
	neighbours.lower = proxy->m_aabbMin - margin;
	neighbours.upper = proxy->m_aabbMax + margin;
	const_cast<btCollisionWorld*>(m_near)->getBroadphase()->aabbTest(neighbours.lower, neighbours.upper, neighbours);
	return neighbours.found;
}

/// Each object is checked once, however many shapes wait.
void btISTTreeSource::orderWhatIsNear()
{
	using State = btISTPendingAttachment::State;
	std::unordered_map<const btCollisionShape*, State*> far;
	for (State* state : m_waiting->states)
		if (!state->order) far.emplace(state->shape, state);
	const int objects = m_near && !far.empty() ? m_near->getNumCollisionObjects() : 0;
	for (int i = 0; i < objects; ++i)
	{
		const btCollisionObject& object = *m_near->getCollisionObjectArray()[i];
		const auto waits = [&](const btCollisionShape* part) { return far.count(part) > 0; };
		if (!btISTAnyPart(object.getCollisionShape(), waits) || !hasNeighbour(object)) continue;
		btISTAnyPart(object.getCollisionShape(), [&](const btCollisionShape* part) {
			if (const auto found = far.find(part); found != far.end()) found->second->begin(), far.erase(found);
			return false;
		});
	}
	if (!m_near)
		for (const auto& [shape, state] : far) state->begin();
}

int btISTTreeSource::update()
{
	int attached = 0;
	auto& states = m_waiting->states;
	orderWhatIsNear();
	for (auto* state : states)
		if (m_registry.keepsLevels() && state->isDone() && state->order->tree() && !ist::hasLevels(*state->order->tree()))
			state->order = m_worker->addLevels(state->order);
	const auto ready = std::stable_partition(states.begin(), states.end(), [](const auto* state) { return !state->isDone(); });
	const std::vector<btISTPendingAttachment::State*> done(ready, states.end());
	states.erase(ready, states.end());
	for (auto* state : done)
	{
		state->attachTo(m_registry);
		attached += state->attachment.isAttached() ? 1 : 0;
	}
	return attached;
}

int btISTTreeSource::finish()
{
	for (auto* state : m_waiting->states) state->begin();
	int attached = 0;
	// Trees without levels wait for them in a second round.
	while (pending() > 0)
	{
		m_worker->finish();
		attached += update();
	}
	return attached;
}

int btISTTreeSource::pending() const { return int(m_waiting->states.size()); }

int btISTTreeSource::waitingForNeighbours() const
{
	const auto& states = m_waiting->states;
	return int(std::count_if(states.begin(), states.end(), [](const auto* state) { return !state->order; }));
}
