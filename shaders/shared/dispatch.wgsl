// Dispatches of more workgroups than a row holds: they come in rows.
#define_import_path hachure::dispatch

// WebGPU's default limit (`maxComputeWorkgroupsPerDimension`).
const GROUPS_IN_ROW: u32 = 65535u;

// The number of a thread among all, in a pass with workgroups of 64.
fn thread_number(id: vec3<u32>) -> u32 {
    return id.x + id.y * GROUPS_IN_ROW * 64u;
}
