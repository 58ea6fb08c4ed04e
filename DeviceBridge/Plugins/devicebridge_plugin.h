/* SPDX-License-Identifier: Zlib */
#pragma once

/* The plug-in interface of DeviceBridge, in C: one shared library, libdevicebridge_NAME.so, makes the devices of the scheme NAME.
 * It is looked for in the folders of DEVICEBRIDGE_PLUGIN_PATH (separated by colons) and in the folder that the library was installed
 * with, loaded when first asked for, and never unloaded: vendors' libraries keep threads of their own.
 *
 * Every struct begins with its size as its maker knew it. The plug-in sets the size of devicebridge_plugin, the host those of
 * the structs that it passes; nobody touches a member that lies beyond the size of the other side. New members are added at the end;
 * DEVICEBRIDGE_PLUGIN_VERSION changes when an old member does, and then the plug-in is refused by name.
 *
 * SI units, radians. W is the device's world frame, H the frame of the handle. No call may throw or end the program. All calls for
 * one device come from one thread; different devices may come from different threads. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C"
{
#endif

#define DEVICEBRIDGE_PLUGIN_VERSION 1u
/* const struct devicebridge_plugin *devicebridge_plugin_entry(void): the one symbol that is looked up. */
#define DEVICEBRIDGE_PLUGIN_ENTRY "devicebridge_plugin_entry"
#define DEVICEBRIDGE_HAND_JOINTS 26

#if defined(_WIN32)
#define DEVICEBRIDGE_PLUGIN_EXPORT __declspec(dllexport)
#else
#define DEVICEBRIDGE_PLUGIN_EXPORT __attribute__((visibility("default")))
#endif

	/* Bits of sensed and actuated: x, y, z, rx, ry, rz, grip, joints of a hand. */
	enum
	{
		DEVICEBRIDGE_TRANSLATION = 0x07,
		DEVICEBRIDGE_ROTATION = 0x38,
		DEVICEBRIDGE_GRIP = 0x40,
		DEVICEBRIDGE_HAND = 0x80
	};

	/* The hand that a device is made for. */
	enum
	{
		DEVICEBRIDGE_LEFT = 1,
		DEVICEBRIDGE_RIGHT = 2
	};

	/* Bits of devicebridge_state.flags; the host sets all of them before each exchange. Force flows while all are set. */
	enum
	{
		DEVICEBRIDGE_CALIBRATED = 1,
		DEVICEBRIDGE_FORCES_ENABLED = 2,
		DEVICEBRIDGE_HAND_PRESENT = 4
	};

	/* Bits of devicebridge_info.assumed, each for one member: limits that the device itself does not tell. */
	enum
	{
		DEVICEBRIDGE_ASSUMED_PEAK_FORCE = 0x01,
		DEVICEBRIDGE_ASSUMED_CONTINUOUS_FORCE = 0x02,
		DEVICEBRIDGE_ASSUMED_PEAK_TORQUE = 0x04,
		DEVICEBRIDGE_ASSUMED_CONTINUOUS_TORQUE = 0x08,
		DEVICEBRIDGE_ASSUMED_MAX_STIFFNESS = 0x10,
		DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_STIFFNESS = 0x20,
		DEVICEBRIDGE_ASSUMED_MAX_DAMPING = 0x40,
		DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_DAMPING = 0x80,
		DEVICEBRIDGE_ASSUMED_DAMPING = 0x100,
		DEVICEBRIDGE_ASSUMED_ANGULAR_DAMPING = 0x200,
		DEVICEBRIDGE_ASSUMED_WORKSPACE_RADIUS = 0x400
	};

	/* Zeros mean unknown; through an unknown peak nothing is sent. Texts end with a zero. */
	struct devicebridge_info
	{
		uint32_t size;
		uint32_t sensed, actuated;
		uint32_t handedness;                         /* DEVICEBRIDGE_LEFT or DEVICEBRIDGE_RIGHT; zero: either, or unknown */
		double peak_force, continuous_force;         /* [N] */
		double peak_torque, continuous_torque;       /* [N m] */
		double max_stiffness, max_angular_stiffness; /* at 1 kHz [N/m, N m/rad] */
		double max_damping, max_angular_damping;     /* at 1 kHz [N s/m, N m s/rad] */
		double resolution, angular_resolution;       /* [m, rad] */
		double workspace_radius;                     /* [m] */
		double nominal_rate;                         /* of the samples [Hz]; zero: 1000 */
		char model[64], maker[64], serial[64];
		char source[256]; /* where the values come from */
		/* From 0.2.0 on: touch them only where `size` reaches so far. */
		double damping, angular_damping; /* that the mechanism itself dissipates [N s/m, N m s/rad] */
		uint32_t assumed, reserved;      /* DEVICEBRIDGE_ASSUMED_... of the values above */
		char profile[64];                /* of data/devices, for what is zero; empty: that of maker and model */
	};

	struct devicebridge_joint
	{
		double position[3];    /* in W */
		double orientation[4]; /* unit quaternion x, y, z, w */
		double radius;
		uint32_t tracked;
		uint32_t reserved;
	};

	struct devicebridge_state
	{
		uint32_t size;
		uint32_t flags, buttons;
		uint32_t velocity_estimated;  /* not zero: from positions rather than measured */
		double position[3];           /* of H in W */
		double rotation[9];           /* of H in W, row major */
		double linear[3], angular[3]; /* velocity of the origin of H and of H, in W */
		double grip_angle, grip_velocity;
		uint32_t hand_is_left, reserved;
		struct devicebridge_joint joints[DEVICEBRIDGE_HAND_JOINTS]; /* order and frames of XR_EXT_hand_tracking */
	};

	/* What the device shall exert on the hand from now on; zeros when nothing was asked for or the last command has expired. */
	struct devicebridge_command
	{
		uint32_t size;
		uint32_t reserved;
		double force[3], torque[3]; /* about the origin of H, in W */
		double grip_force;
	};

	/* Texts that explain go to `why`, with room for `room` bytes and the zero among them. */
	struct devicebridge_plugin
	{
		uint32_t size, version;
		const char *name, *description;
		/* 0: nothing known stands in the way. Else `why` says what is missing and what to install. May be null. */
		int (*missing)(char* why, size_t room);
		/* `address` is what stands behind the scheme. Null: `why` says why not. May take seconds. */
		void* (*open)(const char* address, struct devicebridge_info* info, char* why, size_t room);
		/* Exerts, and waits at most 5 ms for news. 1: `state` is new; 0: no news; -1: the device is lost, `why` says why. */
		int (*exchange)(void* device, const struct devicebridge_command* command, struct devicebridge_state* state, char* why, size_t room);
		/* Leaves the device without force. */
		void (*close)(void* device);
	};

	typedef const struct devicebridge_plugin* (*devicebridge_plugin_entry_function)(void);

#ifdef __cplusplus
}
#endif
