// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/BatchQuery.h"

#include "tests/unit/Core/Query/QueryBodies.h"

#include <gtest/gtest.h>

#include <random>

using namespace ist;

namespace
{
std::vector<OverlapRequest> randomRequests(const std::vector<InnerSphereTree>& bodies, int count)
{
	std::mt19937 random(4);
	std::uniform_real_distribution<double> u(-1, 1);
	std::vector<OverlapRequest> requests(static_cast<size_t>(count));
	for (OverlapRequest& r : requests)
	{
		r.A = &bodies[random() % bodies.size()];
		r.B = &bodies[random() % bodies.size()];
		r.X_AB.rotation = rotationMatrix(quaternionFromRotationVector({u(random), 2, u(random)}));
		r.X_AB.translation = r.A->origin + Vec3{u(random), u(random), u(random)} - r.X_AB.rotation * r.B->origin;
		r.options.model = random() % 4 ? Model::Law : Model::Inner;
	}
	return requests;
}
}  // namespace

TEST(BatchQuery, AnswersEachRequestAsAQueryAlone)
{
	std::vector<InnerSphereTree> bodies;
	for (const int count : {50, 400, 900}) bodies.push_back(cloudBody(count, unsigned(count), {double(count), 0, -3}));
	const std::vector<OverlapRequest> requests = randomRequests(bodies, 40);
	QueryWorkspace workspace;
	for (const int threads : {1, 2, 5})
	{
		BatchQuery batch(threads);
		std::vector<OverlapResult> answers(requests.size());
		for (int repeat = 0; repeat < 2; ++repeat) batch.run(requests.data(), answers.data(), requests.size());
		for (size_t i = 0; i < requests.size(); ++i)
		{
			const OverlapRequest& r = requests[i];
			const OverlapResult alone = queryOverlap(*r.A, *r.B, r.X_AB, workspace, r.options);
			ASSERT_EQ(answers[i].status, QueryStatus::Ok);
			EXPECT_EQ(answers[i].total.pairs, alone.total.pairs);
			EXPECT_EQ(answers[i].total.volume, alone.total.volume);
			EXPECT_EQ(answers[i].total.normalB.torque.z, alone.total.normalB.torque.z);
			EXPECT_EQ(answers[i].patches, nullptr);
			EXPECT_EQ(answers[i].patchCount, 0);
		}
	}
}

TEST(BatchQuery, ABadRequestHasItsOwnError)
{
	const InnerSphereTree body = cloudBody(100, 1), empty;
	std::vector<OverlapRequest> requests(5);
	for (OverlapRequest& r : requests) r.A = r.B = &body;
	requests[0].A = nullptr;
	requests[1].B = &empty;
	requests[2].X_AB.translation.y = NAN;
	requests[3].options.level = 9;
	std::vector<OverlapResult> answers(requests.size());
	BatchQuery(2).run(requests.data(), answers.data(), requests.size());
	EXPECT_EQ(answers[0].status, QueryStatus::EmptyTree);
	EXPECT_EQ(answers[1].status, QueryStatus::EmptyTree);
	EXPECT_EQ(answers[2].status, QueryStatus::InvalidPose);
	EXPECT_EQ(answers[3].status, QueryStatus::Unsupported);
	EXPECT_EQ(answers[4].status, QueryStatus::Ok);
	EXPECT_GT(answers[4].total.volume, 0);
	BatchQuery(1).run(nullptr, nullptr, 0);
}
