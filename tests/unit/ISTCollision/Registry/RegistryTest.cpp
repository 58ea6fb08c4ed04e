// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Registry/btISTRegistry.h"

#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <btBulletCollisionCommon.h>
#include <gtest/gtest.h>

#include <limits>

namespace
{
std::shared_ptr<const ist::InnerSphereTree> boxTree()
{
	static const auto tree = [] {
		ist::BuildOptions options;
		options.maxSpheres = 100;
		auto built = ist::buildTree(ist::makeBoxMesh({0.5, 0.5, 0.5}), options);
		return std::make_shared<const ist::InnerSphereTree>(std::move(built).value());
	}();
	return tree;
}

struct CountingListener : btISTRegistryListener
{
	void treeChanged(const btCollisionShape*) override { ++count; }
	int count = 0;
};
}  // namespace

TEST(btISTRegistry, FindsATreeForAsLongAsItsAttachmentLives)
{
	btISTRegistry registry;
	btBoxShape box(btVector3(.5, .5, .5)), other(btVector3(.5, .5, .5));
	{
		auto attached = registry.attach(&box, boxTree());
		ASSERT_TRUE(attached);
		const btISTAttachment keep = std::move(attached).value();
		EXPECT_TRUE(keep.isAttached());
		EXPECT_EQ(registry.find(&box), boxTree());
		EXPECT_EQ(registry.find(&other), nullptr);
	}
	EXPECT_EQ(registry.find(&box), nullptr);
	EXPECT_EQ(registry.size(), 0);
}

TEST(btISTRegistry, RefusesWithAReason)
{
	btISTRegistry registry;
	btBoxShape box(btVector3(.5, .5, .5)), scaled(btVector3(.5, .5, .5));
	scaled.setLocalScaling(btVector3(2, 1, 1));
	btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
	auto broken = std::make_shared<ist::InnerSphereTree>(*boxTree());
	broken->volume = std::numeric_limits<double>::quiet_NaN();

	EXPECT_FALSE(registry.attach(nullptr, boxTree()));
	EXPECT_FALSE(registry.attach(&box, nullptr));
	EXPECT_FALSE(registry.attach(&plane, boxTree()));
	EXPECT_FALSE(registry.attach(&box, broken));
	const auto refused = registry.attach(&scaled, boxTree());
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("scaling"), std::string::npos);

	const auto first = registry.attach(&box, boxTree());
	ASSERT_TRUE(first);
	EXPECT_FALSE(registry.attach(&box, boxTree()));
	EXPECT_EQ(registry.size(), 1);
}

TEST(btISTRegistry, ForgetsTheTreeOfAShapeThatWasScaledLater)
{
	btISTRegistry registry;
	btBoxShape box(btVector3(.5, .5, .5));
	const auto attached = registry.attach(&box, boxTree());
	ASSERT_TRUE(attached);
	box.setLocalScaling(btVector3(2, 2, 2));
	EXPECT_EQ(registry.find(&box), nullptr);
}

TEST(btISTRegistry, AttachmentMayBeMovedAndMayOutliveTheRegistry)
{
	auto registry = std::make_unique<btISTRegistry>();
	btBoxShape box(btVector3(.5, .5, .5));
	auto result = registry->attach(&box, boxTree());
	ASSERT_TRUE(result);
	btISTAttachment first = std::move(result).value();
	btISTAttachment second = std::move(first);
	EXPECT_FALSE(first.isAttached());
	first = std::move(second);
	EXPECT_EQ(registry->size(), 1);
	registry.reset();
	first.detach();
	EXPECT_FALSE(first.isAttached());
}

TEST(btISTRegistry, TellsItsListenersOfEveryChange)
{
	btISTRegistry registry;
	const auto listener = std::make_shared<CountingListener>();
	registry.addListener(listener);
	btBoxShape box(btVector3(.5, .5, .5));
	{
		const auto attached = registry.attach(&box, boxTree());
		EXPECT_EQ(listener->count, 1);
	}
	EXPECT_EQ(listener->count, 2);
}
