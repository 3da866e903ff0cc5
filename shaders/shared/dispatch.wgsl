// Dispatches of more workgroups than one dimension may have: the rest continues in rows.
#define_import_path hachure::dispatch

// WebGPU's default limit (`maxComputeWorkgroupsPerDimension`).
const GROUPS_IN_ROW: u32 = 65535u;

// Returns the number of a thread in the whole dispatch, for workgroups of 64.
fn thread_number(id: vec3<u32>) -> u32 {
    return id.x + id.y * GROUPS_IN_ROW * 64u;
}
