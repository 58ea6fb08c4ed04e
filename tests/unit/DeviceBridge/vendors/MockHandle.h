// SPDX-License-Identifier: Zlib
#pragma once

#include <mutex>

/// State that a mock of a vendor's library shares with the test that has loaded the same file. SI units.
struct MockHandle
{
	std::mutex mutex;
	double position[3] = {0, 0, 0}, linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
	double quaternion[4] = {0, 0, 0, 1};  // x, y, z, w
	unsigned buttons = 0;
	bool present = true, calibrated = true, motorsOn = true, handPresent = true, tellsVelocity = true;
	double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};
	int open = 0, enabled = 0, misuse = 0;  // misuse: number of calls that the vendor's documentation forbids
};

#define MOCK_EXPORT extern "C" __attribute__((visibility("default")))
MOCK_EXPORT MockHandle* mockHandle();

/// Row-major matrix of a unit quaternion, by rotating the three axes.
inline void mockRotation(const double (&q)[4], double (&m)[3][3])
{
	for (int column = 0; column < 3; ++column)
	{
		const double v[3] = {column == 0 ? 1.0 : 0.0, column == 1 ? 1.0 : 0.0, column == 2 ? 1.0 : 0.0};
		// v + 2 w (u x v) + 2 u x (u x v)
		const double c[3] = {q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2], q[0] * v[1] - q[1] * v[0]};
		const double d[3] = {q[1] * c[2] - q[2] * c[1], q[2] * c[0] - q[0] * c[2], q[0] * c[1] - q[1] * c[0]};
		for (int row = 0; row < 3; ++row) m[row][column] = v[row] + 2 * q[3] * c[row] + 2 * d[row];
	}
}
