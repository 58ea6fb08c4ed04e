// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/btISTTreeSource.h"

#include "BulletISTCollision/btISTShapeMesh.h"

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"

#include <algorithm>
#include <filesystem>
#include <utility>

/// The states that still wait; a state that goes takes itself out.
struct btISTTreeSource::Waiting
{
	std::vector<btISTPendingAttachment::State*> states;
};

struct btISTPendingAttachment::State
{
	const btCollisionShape* shape = nullptr;
	std::shared_ptr<const ist::TreeOrder> order;
	std::weak_ptr<btISTTreeSource::Waiting> waiting;
	btVector3 scaling{1, 1, 1};  // that the tree is made for
	btISTAttachment attachment;
	std::string error, note;

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
		if (attached)
			attachment = std::move(attached).value();
		else
			error = attached.error().message;
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

std::shared_ptr<const ist::InnerSphereTree> btISTPendingAttachment::tree() const
{
	return isAttached() ? m_state->order->tree() : nullptr;
}

btISTTreeSource::btISTTreeSource(btISTRegistry& registry, btISTTreeSettings settings)
	: m_registry(registry), m_settings(std::move(settings)), m_waiting(std::make_shared<Waiting>()),
	  m_worker(std::make_unique<ist::TreeWorker>(m_settings.cacheFolder, m_settings.mostDoubt))
{
}

btISTTreeSource::~btISTTreeSource()
{
	m_worker.reset();
	for (auto* state : m_waiting->states) state->error = "the source of the trees is gone";
}

btISTPendingAttachment btISTTreeSource::expect(const btCollisionShape* shape, const btVector3& scaling,
											   std::shared_ptr<const ist::TreeOrder> order)
{
	auto state = std::make_unique<btISTPendingAttachment::State>();
	state->shape = shape;
	state->scaling = scaling;
	state->order = std::move(order);
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

btISTPendingAttachment btISTTreeSource::attach(const btCollisionShape* shape)
{
	auto failed = std::make_unique<btISTPendingAttachment::State>();
	failed->shape = shape;
	failed->error = refusalToWait(m_registry, shape, awaits(shape));
	if (!failed->error.empty()) return btISTPendingAttachment(std::move(failed));
	ist::Result<ist::Mesh> mesh = meshOfShape(*shape);
	if (mesh) return expect(shape, shape->getLocalScaling(), m_worker->build(std::move(mesh).value(), m_settings.build));
	failed->error = mesh.error().message;
	return btISTPendingAttachment(std::move(failed));
}

btISTPendingAttachment btISTTreeSource::attachAsset(const btCollisionShape* shape, const std::string& path)
{
	auto failed = std::make_unique<btISTPendingAttachment::State>();
	failed->shape = shape;
	failed->error = refusalToWait(m_registry, shape, awaits(shape));
	if (!failed->error.empty()) return btISTPendingAttachment(std::move(failed));
	return expect(shape, btVector3(1, 1, 1), m_worker->load(path));
}

btISTPendingAttachment btISTTreeSource::unknown(const char* name)
{
	auto state = std::make_unique<btISTPendingAttachment::State>();
	state->error = std::string("no shape and no body of the loaded file is named \"") + name + "\"";
	return btISTPendingAttachment(std::move(state));
}

std::vector<std::string> btISTTreeSource::assetNames(const std::string& folder)
{
	std::vector<std::string> names;
	std::error_code ignored;
	for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
		if (entry.path().extension() == ".ist") names.push_back(entry.path().stem().string());
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

int btISTTreeSource::update()
{
	int attached = 0;
	auto& states = m_waiting->states;
	const auto ready = std::stable_partition(states.begin(), states.end(), [](const auto* state) { return !state->order->isDone(); });
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
	m_worker->finish();
	return update();
}

int btISTTreeSource::pending() const { return int(m_waiting->states.size()); }
